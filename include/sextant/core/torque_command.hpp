#pragma once

#include <cstdint>

namespace sextant {

/// State of the end-to-end check of received commands (AUTOSAR E2E, check state machine).
enum class E2eState : std::uint8_t { no_data, init, valid, invalid };

/// What came from the vehicle control unit: the newest accepted command and how reception is doing.
/// The receive thread writes it, the control thread reads it.
template <class T = double>
struct TorqueCommand {
  T torque{};                  ///< requested torque, signed [N·m]
  T torque_limit{};            ///< magnitude that the requester allows [N·m]
  bool enable{false};          ///< torque production wanted
  bool fault_reset{false};     ///< latched faults may be cleared
  std::int64_t received_ns{};  ///< when the frame arrived, on the drive's clock [ns]
  std::uint32_t sequence{};    ///< counts accepted frames; 0 while none has come
  std::uint32_t rejected{};    ///< frames dropped: CRC, repeated or lost counter, length, data id
  std::uint8_t counter{};      ///< the E2E counter of the frame, echoed in the status
  E2eState e2e{E2eState::no_data};
  std::uint32_t out_of_range{};  ///< consecutive frames whose torque was outside the contract's range
  bool bus_off{false};           ///< the CAN controller has left the bus
};

}  // namespace sextant
