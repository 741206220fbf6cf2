#pragma once

#include <cstdint>

namespace sextant {

/// State of the end-to-end check of received commands (AUTOSAR E2E, check state machine).
enum class E2eState : std::uint8_t { no_data, init, valid, invalid };

/// The newest accepted command of the vehicle control unit, and the state of its reception. The receive
/// thread writes it; the control thread reads the newest one, so that a command may be overwritten unread.
/// The counts of disables and resets keep those: the command supervision compares them for change, and they
/// may wrap. A source whose every command is read may leave both at zero.
///
/// A frame with Enable = 0 is a disable with any torque and limit: "not available" and numbers out of range
/// are accepted in it, and are zero here.
template <class T = double>
struct TorqueCommand {
  T torque{};                  ///< requested torque, signed [N·m]
  T torque_limit{};            ///< magnitude that the requester allows [N·m]
  bool enable{false};          ///< torque production requested
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
  bool second_sender{false};     ///< another VCU sends under the command's identifier
};

}  // namespace sextant
