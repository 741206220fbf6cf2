#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "sextant/comms/can_frame.hpp"
#include "sextant/comms/status_messages.hpp"
#include "sextant/core/identifier_offset.hpp"
#include "sextant/core/torque_command.hpp"

namespace sextant {

// Conversion between frames of configs/interfaces/sextant.dbc and plain structs. Scaling and layout are
// generated from that file. The codec leaves the E2E bytes of protected frames zero; E2eProtector fills them.

/// A status frame. A value beyond the signal's range is sent as the range's end, NaN as the value nearest to
/// zero; `clamped` is then true. No status frame is lost and no value wraps.
struct EncodedFrame {
  CanFrame frame;
  bool clamped{false};
};

[[nodiscard]] EncodedFrame encode(const TorqueStatus& x) noexcept;
[[nodiscard]] EncodedFrame encode(const Motion& x) noexcept;
[[nodiscard]] EncodedFrame encode(const Electrical& x) noexcept;
[[nodiscard]] EncodedFrame encode(const Capability& x) noexcept;
[[nodiscard]] EncodedFrame encode(const FaultReport& x) noexcept;
[[nodiscard]] EncodedFrame encode(const ActiveFaults& x) noexcept;
[[nodiscard]] EncodedFrame encode(const LatchedFaults& x) noexcept;
[[nodiscard]] EncodedFrame encode(const RealTimeReport& x) noexcept;
[[nodiscard]] EncodedFrame encode(const Temperatures& x) noexcept;
[[nodiscard]] EncodedFrame encode(const Identification& x) noexcept;

/// VCU_TorqueCommand, as a vehicle control unit sends it: torque, limit, enable and reset of the command.
[[nodiscard]] EncodedFrame encode(const TorqueCommand<double>& x) noexcept;

/// How a frame relates to the command's identity.
enum class CommandIdentity : std::uint8_t {
  command,         ///< a classic data frame of the right id and length
  other,           ///< another id
  wrong_length,    ///< the command's id with other than eight bytes
  remote,          ///< a remote request for the command
  extended_alias,  ///< the same number as a 29-bit identifier
  fd_alias         ///< a CAN FD frame under the command's id
};

[[nodiscard]] CommandIdentity identify_command(const CanFrame& frame, IdentifierOffset offset = {}) noexcept;

struct DecodedCommand {
  TorqueCommand<double> command;  ///< torque, limit, enable, reset and counter; nothing of its reception
  bool in_range{false};           ///< torque and limit lie within the ranges of the contract
};

/// Decodes the payload of a frame whose identity is `command`.
[[nodiscard]] DecodedCommand decode_command(const CanFrame& frame) noexcept;

/// The identifiers that a drive receives: the command, under each identity that `identify_command`
/// distinguishes, and MCU_TorqueStatus, which on this bus only another drive sends.
[[nodiscard]] std::array<CanIdentifier, 3> drive_identifiers(IdentifierOffset offset = {}) noexcept;

/// Identifier and E2E data id of VCU_TorqueCommand.
[[nodiscard]] std::uint32_t command_id(IdentifierOffset offset = {}) noexcept;
[[nodiscard]] std::uint16_t command_data_id(IdentifierOffset offset = {}) noexcept;

/// Decodes an MCU_TorqueStatus, as a vehicle does; empty for any other frame. The caller checks the
/// end-to-end bytes.
[[nodiscard]] std::optional<TorqueStatus> decode_torque_status(const CanFrame& frame,
                                                               IdentifierOffset offset = {}) noexcept;

/// E2E data id of MCU_TorqueStatus.
[[nodiscard]] std::uint16_t torque_status_data_id(IdentifierOffset offset = {}) noexcept;

}  // namespace sextant
