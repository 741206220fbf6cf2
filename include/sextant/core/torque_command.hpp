#pragma once

#include <cstdint>

namespace sextant {

/// State of the end-to-end check of received commands (AUTOSAR E2E, check state machine).
enum class E2eState : std::uint8_t { no_data, init, valid, invalid };

/// What came from the vehicle control unit: the newest accepted command and how reception is doing.
/// The receive thread writes it, the control thread reads it; the control thread sees the newest one only, so
/// that a command may be overwritten before it is seen. The counts of disables and resets tell of those that
/// were: the command supervision compares them for change, and they may wrap. A source of which every command
/// is seen may leave both at zero.
///
/// A frame with Enable = 0 is a disable whatever its torque and its limit are: "not available" and numbers
/// out of range are accepted there, and stand here as zero.
template <class T = double>
struct TorqueCommand {
  T torque{};                  ///< requested torque, signed [N·m]
  T torque_limit{};            ///< magnitude that the requester allows [N·m]
  bool enable{false};          ///< torque production wanted
  bool fault_reset{false};     ///< latched faults may be cleared
  std::int64_t received_ns{};  ///< when the frame arrived, on the drive's clock [ns]
  std::uint64_t sequence{};    ///< counts accepted frames; 0 while none has come
  std::uint32_t disables{};    ///< accepted frames with Enable = 0
  std::uint32_t resets{};      ///< of these, frames with FaultReset = 1
  std::uint32_t rejected{};    ///< frames dropped: CRC, repeated or lost counter, length, data id
  std::uint8_t counter{};      ///< the E2E counter of the frame, echoed in the status
  E2eState e2e{E2eState::no_data};
  std::uint32_t out_of_range{};  ///< consecutive frames with Enable = 1, dropped for the contract's range
  bool bus_off{false};           ///< the CAN controller has left the bus
};

}  // namespace sextant
