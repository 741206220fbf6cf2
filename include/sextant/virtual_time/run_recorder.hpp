#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "sextant/comms/can_frame.hpp"
#include "sextant/core/telemetry_interval.hpp"
#include "sextant/virtual_time/digest.hpp"

namespace sextant {

/// Callbacks for the observations of a run; each may be empty.
struct RunHandlers {
  std::function<void(const Telemetry<double>&)> period{};                ///< every control period
  std::function<void(const TelemetryIntervalRecord<double>&)> record{};  ///< every interval of them
  std::function<void(const CanFrame&, std::int64_t t_ns)> frame{};       ///< every frame sent, and when [ns]
};

/// Adds every control period and every frame that the drive sent to a digest, so that two runs can be
/// compared bit for bit, and passes them to the callbacks.
class RunRecorder {
 public:
  /// Control periods of an interval, at least one. [-]
  explicit RunRecorder(std::uint32_t periods_per_record = 40, RunHandlers handlers = {})
      : periods_per_record_{periods_per_record}, handlers_{std::move(handlers)} {}

  void add(const Telemetry<double>& telemetry) {
    ++periods_;
    telemetry_.add(telemetry);
    if (handlers_.period) handlers_.period(telemetry);
    if (!handlers_.record) return;
    interval_.add(telemetry);
    if (interval_.count() < periods_per_record_) return;
    handlers_.record(interval_.record());
    interval_.reset();
  }

  void add(const CanFrame& frame, std::int64_t t_ns) {
    ++frames_;
    sent_.add(frame, t_ns);
    if (handlers_.frame) handlers_.frame(frame, t_ns);
  }

  [[nodiscard]] std::uint64_t periods() const noexcept { return periods_; }  ///< control periods seen [-]
  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }    ///< frames sent [-]

  /// Of the control periods, of the frames, and of both.
  [[nodiscard]] std::uint64_t telemetry_digest() const noexcept { return telemetry_.value(); }
  [[nodiscard]] std::uint64_t frames_digest() const noexcept { return sent_.value(); }
  [[nodiscard]] std::uint64_t digest() const noexcept {
    Digest both;
    both.add(telemetry_.value());
    both.add(sent_.value());
    return both.value();
  }

 private:
  std::uint32_t periods_per_record_;
  RunHandlers handlers_;
  TelemetryInterval<double> interval_{};
  Digest telemetry_{};
  Digest sent_{};
  std::uint64_t periods_{0};
  std::uint64_t frames_{0};
};

}  // namespace sextant
