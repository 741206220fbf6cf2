#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sextant/comms/can_codec.hpp"
#include "sextant/comms/e2e_profile11.hpp"
#include "sextant/core/telemetry.hpp"

namespace sextant {

/// The status messages of the drive, in the order in which those due at one time are sent: the first fault
/// before the state that it causes.
enum class StatusMessage : std::uint8_t {
  faults,
  torque_status,
  motion,
  electrical,
  capability,
  real_time,
  temperatures,
  faults_active,
  faults_latched,
  identification
};

inline constexpr std::size_t status_message_count = 10;

/// Cycle time of the message, from the contract. [ns]
[[nodiscard]] std::int64_t cycle_time_ns(StatusMessage message) noexcept;

/// True for a frame with the identifier of a status message.
[[nodiscard]] bool is_status_frame(const CanFrame& frame, IdentifierOffset offset = {}) noexcept;

/// Contents of the status frames beside the telemetry of the drive.
struct StatusExtras {
  RealTimeReport real_time{};
  bool measured{
      true};  ///< false: the measurements are out of date; MCU_Motion and MCU_Electrical are not sent
};

/// Makes the status frames of the drive, protected and counted. It belongs to the transmit thread.
class StatusEncoder {
 public:
  /// offset: of the drive's identifiers and data ids.
  explicit StatusEncoder(IdentifierOffset offset = {}) noexcept;

  [[nodiscard]] CanFrame frame(StatusMessage message, const Telemetry<double>& drive,
                               const StatusExtras& extras) noexcept;

  /// The frames that are due at now_ns [ns, any fixed clock], at most one of each message: all of them at the
  /// first call, then each by its cycle time with its phase kept, the three of the faults when one of
  /// them changed, and MCU_Capability when a ramp to zero begins or ends. Cycles without a call are left out.
  /// The frames stay valid until the next call.
  [[nodiscard]] std::span<const CanFrame> due(std::int64_t now_ns, const Telemetry<double>& drive,
                                              const StatusExtras& extras) noexcept;

  /// When the next cyclic frame is due; 0 before the first call of `due`. [ns]
  [[nodiscard]] std::int64_t next_due_ns() const noexcept;

  /// Frames in which a value was beyond its range. [-]
  [[nodiscard]] std::uint64_t clamped() const noexcept { return clamped_; }

 private:
  void protect(StatusMessage message, CanFrame& frame) noexcept;
  /// True by the cycle time, or where what the message tells has changed.
  [[nodiscard]] bool is_due(std::size_t message, std::int64_t now_ns, bool changed) noexcept;

  IdentifierOffset offset_;
  std::array<std::optional<E2eProtector>, status_message_count> protectors_{};  ///< of the protected ones
  FaultSet sent_active_{};
  FaultSet sent_latched_{};
  FaultReport sent_faults_{};
  DeratingCause sent_cause_{};
  std::array<std::int64_t, status_message_count> next_ns_{};
  std::array<CanFrame, status_message_count> frames_{};
  bool started_{false};
  std::uint64_t clamped_{0};
};

}  // namespace sextant
