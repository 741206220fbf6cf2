#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "sextant/core/drive_io.hpp"

namespace sextant {

/// A signal of the measurement.
enum class MeasuredSignal : std::uint8_t { i_a, i_b, i_c, u_dc, omega_m };

/// Something that is wrong with what the drive measures, in [begin, end): the signal reads
/// gain · x + offset of what it is, or NaN and infinity where gain or offset are; or, with `holds_currents`,
/// all phase currents keep their readings before it, as of a converter that has stopped.
struct MeasurementEvent {
  MeasuredSignal signal{MeasuredSignal::i_a};
  std::int64_t begin_ns{0};  ///< [ns]
  std::int64_t end_ns{0};    ///< [ns]
  double gain{0.0};          ///< [-]
  double offset{0.0};        ///< [A], [V] or [rad/s]
  bool holds_currents{false};
};

/// A power stage whose measurements are wrong by a script; patterns go through unchanged.
class DisturbedDriveIo final : public DriveIo<double> {
 public:
  /// The power stage is not owned and must outlive this object.
  explicit DisturbedDriveIo(DriveIo<double>& io, std::vector<MeasurementEvent> events = {})
      : io_{io}, events_{std::move(events)} {}

  void add(const MeasurementEvent& event) { events_.push_back(event); }

  [[nodiscard]] Measurement<double> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING override {
    Measurement<double> m = io_.read(t_ns);
    for (const MeasurementEvent& event : events_) {
      if (event.begin_ns > t_ns || t_ns >= event.end_ns) continue;
      if (event.holds_currents) {
        m.i_abc = currents_;
        continue;
      }
      double& x = signal(m, event.signal);
      x = event.gain * x + event.offset;
    }
    currents_ = m.i_abc;
    return m;
  }
  void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override { io_.write(pattern); }

  /// What the drive read last. [A]
  [[nodiscard]] const ThreePhase<double>& currents() const noexcept { return currents_; }

 private:
  [[nodiscard]] static double& signal(Measurement<double>& m, MeasuredSignal which) noexcept {
    switch (which) {
      case MeasuredSignal::i_a:
        return m.i_abc.a;
      case MeasuredSignal::i_b:
        return m.i_abc.b;
      case MeasuredSignal::i_c:
        return m.i_abc.c;
      case MeasuredSignal::u_dc:
        return m.u_dc;
      case MeasuredSignal::omega_m:
        break;
    }
    return m.omega_m;
  }

  DriveIo<double>& io_;
  std::vector<MeasurementEvent> events_;
  ThreePhase<double> currents_{};
};

}  // namespace sextant
