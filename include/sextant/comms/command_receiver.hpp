#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sextant/comms/can_codec.hpp"
#include "sextant/comms/can_frame.hpp"
#include "sextant/comms/e2e_profile11.hpp"
#include "sextant/comms/other_drive.hpp"
#include "sextant/core/torque_command.hpp"

namespace sextant {

/// What became of a received frame: one of these, and each is counted.
enum class FrameVerdict : std::uint8_t {
  accepted,     ///< the command was taken over
  unrelated,    ///< another identifier
  error_frame,  ///< a report of the interface
  other_drive,  ///< a status frame by which another drive is known
  // Rejected from here on: a frame under the command's identifier, and the command before it is held.
  not_valid_yet,  ///< a good frame, but the E2E state is not VALID
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

[[nodiscard]] constexpr bool is_rejection(FrameVerdict v) noexcept {
  return v >= FrameVerdict::not_valid_yet;
}
[[nodiscard]] const char* to_string(FrameVerdict v) noexcept;

/// Turns the frames of the bus into the newest command: checks identity, end-to-end protection and range of
/// each frame, holds the last command when one is bad, and counts. It takes commands over only while the E2E
/// state is VALID, and leaves age, rate and plausibility to the command supervision. It belongs to the
/// receive thread, which sees every frame.
///
/// Every frame has one verdict, and the frames under the command's identifier are those accepted and those
/// rejected. A disable is accepted whatever its torque is. Bus-off lasts until a command is accepted
/// `bus_off_hold` or more after the last report of it: a controller that falls off the bus again and again is
/// off all the time.
class CommandReceiver {
 public:
  struct Parameters {
    E2eChecker::Parameters e2e{};
    std::int64_t bus_off_hold_ns{20'000'000};  ///< bus-off lasts at least so long, for others to see it [ns]

    [[nodiscard]] constexpr const char* validate() const noexcept {
      if (bus_off_hold_ns < 0) return "bus_off_hold must not be negative";
      return e2e.validate();
    }
  };

  CommandReceiver() noexcept : CommandReceiver(Parameters{}) {}
  explicit CommandReceiver(const Parameters& parameters) noexcept;

  /// Takes one frame with its arrival time. `command()` may have changed after any verdict but `unrelated`.
  FrameVerdict on_frame(const CanFrame& frame) noexcept;

  [[nodiscard]] const TorqueCommand<double>& command() const noexcept { return command_; }

  /// Frames with this verdict since start. [-]
  [[nodiscard]] std::uint64_t count(FrameVerdict v) const noexcept { return counts_[std::size_t(v)]; }
  /// Frames under the command's identifier that were not accepted, for whatever cause, since start. [-]
  [[nodiscard]] std::uint64_t rejected() const noexcept { return rejected_; }

 private:
  FrameVerdict judge(const CanFrame& frame) noexcept;
  FrameVerdict take(const CanFrame& frame) noexcept;
  void accept(const TorqueRequest& request) noexcept;
  FrameVerdict on_error_frame(const CanFrame& frame) noexcept;

  Parameters parameters_;
  E2eChecker checker_;
  OtherDrive other_drive_{};
  TorqueCommand<double> command_{};
  std::int64_t bus_off_ns_{0};
  std::array<std::uint64_t, frame_verdict_count> counts_{};
  std::uint64_t rejected_{0};
};

}  // namespace sextant
