#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/recording/trace_reducer.hpp"

namespace sextant {

/// Divides control periods into the rows of a trace whose interval is a whole part of the period.
///
/// Between the ends of a gate segment the plant's values run linearly, as in `PlantEnvelope`; every switching
/// instant is such an end. The drive's values are those of its last control period, and a row within a period
/// has `periods` 0. The last row of a period ends with the next control period and is completed by it.
class TraceDivider {
 public:
  /// parts: rows a control period, at least 1; interval: of one row [ns].
  TraceDivider(std::uint32_t parts, std::int64_t interval_ns) noexcept
      : parts_{parts}, interval_ns_{interval_ns}, left_ns_{interval_ns} {}

  /// Adds a gate segment of the control period to come: the plant at both of its ends, and its length [s].
  /// `append` is called with each row that ends in it.
  template <class Append>
  void add_segment(const PlantSample& before, const PlantSample& after, double seconds, Append&& append) {
    const std::int64_t length_ns = std::llround(seconds * 1e9);
    PlantSample begin = before;
    std::int64_t done_ns = 0;
    while (part_ + 1 < parts_ && left_ns_ <= length_ns - done_ns) {
      done_ns += left_ns_;
      const PlantSample end = between(before, after, double(done_ns) / double(length_ns));
      rows_.add_segment(begin, end, double(left_ns_) * 1e-9);
      append(rows_.take_part(end, t_ns_ + ++part_ * interval_ns_));
      begin = end;
      left_ns_ = interval_ns_;
    }
    rows_.add_segment(begin, after, double(length_ns - done_ns) * 1e-9);
    left_ns_ -= length_ns - done_ns;
  }

  /// Adds a control period, with the plant at its end, and returns the row that it completes.
  [[nodiscard]] TraceRow add(const Telemetry<>& telemetry, const PlantSample& plant,
                             const ControlSample& control = {}) noexcept {
    static_cast<void>(rows_.add(telemetry, plant, control));
    t_ns_ = telemetry.t_ns;
    part_ = 0;
    left_ns_ = interval_ns_;
    return rows_.take();
  }

 private:
  /// The plant at a share of a segment.
  [[nodiscard]] static PlantSample between(const PlantSample& a, const PlantSample& b,
                                           double share) noexcept {
    const auto line = [share](double from, double to) { return from + share * (to - from); };
    const auto vector = [&line](const SpaceVector<>& from, const SpaceVector<>& to) {
      return SpaceVector<>{line(from.alpha, to.alpha), line(from.beta, to.beta)};
    };
    return {.torque = line(a.torque, b.torque),
            .tau_l = line(a.tau_l, b.tau_l),
            .psi_s = vector(a.psi_s, b.psi_s),
            .psi_r = vector(a.psi_r, b.psi_r),
            .i_abc = {line(a.i_abc.a, b.i_abc.a), line(a.i_abc.b, b.i_abc.b), line(a.i_abc.c, b.i_abc.c)},
            .u_dc = line(a.u_dc, b.u_dc),
            .omega_m = line(a.omega_m, b.omega_m),
            .theta_m = line(a.theta_m, b.theta_m),
            .i_dc = line(a.i_dc, b.i_dc),
            .state = b.state,
            .u_s = vector(a.u_s, b.u_s),
            .i_r = vector(a.i_r, b.i_r),
            .energies = {line(a.energies.link, b.energies.link),
                         line(a.energies.copper, b.energies.copper),
                         line(a.energies.shaft, b.energies.shaft),
                         line(a.energies.field, b.energies.field),
                         line(a.energies.iron, b.energies.iron),
                         {},
                         {}},
            .temperatures = b.temperatures,
            .load = LoadSample::between(a.load, b.load, share)};
  }

  std::uint32_t parts_;
  std::int64_t interval_ns_;  ///< [ns]
  TraceReducer rows_{1};
  std::int64_t t_ns_{0};     ///< the last control period [ns]
  std::uint32_t part_{0};    ///< rows since then
  std::int64_t left_ns_{0};  ///< until the end of the row [ns]
};

}  // namespace sextant
