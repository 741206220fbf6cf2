#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sextant/comms/can_codec.hpp"
#include "sextant/comms/can_frame.hpp"
#include "sextant/comms/e2e_profile11.hpp"
#include "sextant/comms/other_drive.hpp"
#include "sextant/comms/second_sender.hpp"
#include "sextant/core/torque_command.hpp"

namespace sextant {

/// The result of a received frame; each result is counted.
enum class FrameVerdict : std::uint8_t {
  accepted,     ///< the command replaces the one before
  unrelated,    ///< another identifier
  error_frame,  ///< a report of the interface
  other_drive,  ///< a status frame of another drive
  // Rejected, from here on: the frame has the command's identifier; the command before it is held.
  not_valid_yet,  ///< the check of the frame passed, but the E2E state is not VALID
  wrong_length,
  remote_frame,
  extended_alias,
  fd_alias,
  wrong_crc,
  wrong_data_id,
  invalid_counter,
  repeated,
  wrong_sequence,
  out_of_range
};

inline constexpr std::size_t frame_verdict_count = 15;
static_assert(frame_verdict_count == std::size_t(FrameVerdict::out_of_range) + 1);

[[nodiscard]] constexpr bool is_rejection(FrameVerdict v) noexcept {
  return v >= FrameVerdict::not_valid_yet;
}
[[nodiscard]] const char* to_string(FrameVerdict v) noexcept;

/// Turns the frames of the bus into the newest command: checks identity, end-to-end protection and range of
/// each frame, and counts the results. A rejected frame leaves the command before it in place. Commands are
/// accepted only while the E2E state is VALID. The command supervision checks age, rate and availability.
/// The receiver belongs to the receive thread, which handles every frame.
///
/// Every frame has one verdict; each frame under the command's identifier is either accepted or rejected. A
/// disable is accepted with any torque. Bus-off lasts until a command is accepted `bus_off_hold` or more
/// after the last report, so that a controller that leaves the bus repeatedly counts as off throughout.
class CommandReceiver {
 public:
  struct Parameters {
    IdentifierOffset identifier_offset{};  ///< of the drive's identifiers and data ids
    E2eChecker::Parameters e2e{};
    SecondSender::Parameters second_sender{};
    std::int64_t bus_off_hold_ns{20'000'000};  ///< shortest duration of a reported bus-off [ns]

    [[nodiscard]] constexpr const char* validate() const noexcept {
      if (const char* problem = identifier_offset.validate()) return problem;
      if (bus_off_hold_ns < 0) return "bus_off_hold must not be negative";
      if (const char* problem = second_sender.validate()) return problem;
      return e2e.validate();
    }
  };

  CommandReceiver() noexcept : CommandReceiver(Parameters{}) {}
  explicit CommandReceiver(const Parameters& parameters) noexcept;

  /// Evaluates one frame with its arrival time. `command()` may have changed after any verdict but
  /// `unrelated`.
  FrameVerdict on_frame(const CanFrame& frame) noexcept;

  [[nodiscard]] const TorqueCommand<double>& command() const noexcept { return command_; }

  /// Frames with this verdict since start. [-]
  [[nodiscard]] std::uint64_t count(FrameVerdict v) const noexcept { return counts_[std::size_t(v)]; }
  /// Frames under the command's identifier that were not accepted, since start. [-]
  [[nodiscard]] std::uint64_t rejected() const noexcept { return rejected_; }

 private:
  FrameVerdict evaluate(const CanFrame& frame) noexcept;
  FrameVerdict accept(const CanFrame& frame) noexcept;
  void store(const DecodedCommand& decoded) noexcept;
  FrameVerdict on_error_frame(const CanFrame& frame) noexcept;

  Parameters parameters_;
  E2eChecker checker_;
  OtherDrive other_drive_;
  SecondSender second_sender_;
  TorqueCommand<double> command_{};
  std::int64_t bus_off_ns_{0};
  std::array<std::uint64_t, frame_verdict_count> counts_{};
  std::uint64_t rejected_{0};
};

}  // namespace sextant
