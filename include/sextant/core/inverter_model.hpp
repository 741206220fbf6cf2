#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/inverter_parameters.hpp"
#include "sextant/core/leg_timing.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"
#include "sextant/core/two_level_inverter.hpp"

namespace sextant {

/// The inverter as the drive takes it to be: by how much the volt-seconds of each leg differ from those of
/// the commanded pattern.
///
/// Dead time. Where a leg changes between low and high both of its switches are off for t_d. Its potential v
/// is then 0 while i_x > 0 and u_dc while i_x < 0, by the diodes; where the current reaches zero it stays
/// there, and v is what keeps it, within [0, u_dc]. So a leg whose current keeps its sign loses
/// sign(i_x) u_dc t_d in a period of two changes. Drops: a switch or diode that carries i_x takes
/// (V_t + r |i_x|) sign(i_x).
///
/// Minimum pulse (`LegTiming`): u_dc for the difference of the commanded time and the acting one, and where
/// the gate drivers drop pulses all edges act t_min late, which counts where a leg does not end a period as
/// it began it.
///
/// The sign of a current near zero follows from its course through the pattern, from the reading at its
/// beginning, with the potentials as above:
///   di_x/dt = u_x/σL_s + d_x
/// d_x is what EMF and resistance change. It is that of the interval before, corrected by what the current
/// would miss the reading at the end by, over the time, in each of two passes. A current that dead times stop
/// hides a part of d_x: then a pass corrects a part of its error, and the intervals together all of it, as it
/// turns slowly.
/// Sources: S.-G. Jeong, M.-H. Park, "The analysis and compensation of dead-time effects in PWM inverters",
/// IEEE Trans. Ind. Electron. 38 (1991) 108–114; for the drops A. R. Muñoz, T. A. Lipo, "On-line dead-time
/// compensation technique for open-loop PWM-VSI drives", IEEE Trans. Power Electron. 14 (1999) 683–689.
///
/// Not in the model: switching times, and currents that are read wrong by as much as they change within a
/// period.
template <class T = double>
class InverterModel {
 public:
  using Parameters = InverterParameters<T>;
  using Legs = LegTiming::Legs;

  /// leakage: σL_s of the machine. [H]
  constexpr InverterModel(const Parameters& parameters, T leakage) noexcept
      : parameters_{parameters},
        timing_{parameters.dead_time_ns, parameters.minimum_pulse},
        is_ideal_{parameters.is_ideal()},
        has_drops_{parameters.threshold_voltage != T(0) || parameters.slope_resistance != T(0)},
        inverse_leakage_{T(1) / leakage} {}

  [[nodiscard]] constexpr bool is_ideal() const noexcept { return is_ideal_; }
  /// The legs at the last measurement.
  [[nodiscard]] constexpr const Legs& legs() const noexcept { return legs_; }

  /// The measurement at the end of an applied pattern, with the phase currents [A] and the link voltage [V];
  /// each one, in order. ∫u_x dt beyond that of an ideal inverter; zero where a leg was off. [V·s]
  [[nodiscard]] constexpr ThreePhase<T> step(const GatePattern& applied, const ThreePhase<T>& i,
                                             T u_dc) noexcept {
    if (is_ideal_) return {};
    const Course course{phases(i_), phases(i), std::max(T(0), u_dc), seconds(applied.duration_ns())};
    i_ = i;
    if (!applied.is_driven() || applied.duration_ns() == 0) {
      timing_.pass(applied, legs_);
      if (!applied.is_driven()) drift_ = {};
      return {};
    }
    Legs after{};
    Phases beyond{};
    for (int n = 0; n < passes; ++n) {
      after = legs_;
      const Way way = through(applied, course, drift_, after);
      for (std::size_t k = 0; k < 3; ++k) drift_[k] += (course.i_end[k] - way.i[k]) / course.duration;
      beyond = way.beyond;
    }
    legs_ = after;
    return without_common(beyond);
  }

  /// The same of each leg's own potential for a pattern to come, in which every leg is driven, from these
  /// legs on, which are left as they are at its end. i: currents at its beginning, and at its end as an ideal
  /// inverter would make them. [V·s]
  [[nodiscard]] constexpr ThreePhase<T> predicted(const GatePattern& pattern, SpaceVector<T> i_begin,
                                                  SpaceVector<T> i_end, T u_dc, Legs& legs) const noexcept {
    const Course course{phases(inverse_clarke(i_begin)), phases(inverse_clarke(i_end)), std::max(T(0), u_dc),
                        seconds(pattern.duration_ns())};
    const Phases v = through(pattern, course, ideal_drift(pattern, course), legs).beyond;
    return {v[0], v[1], v[2]};
  }

  /// The legs go through a pattern.
  constexpr void pass(const GatePattern& pattern, Legs& legs) const noexcept { timing_.pass(pattern, legs); }

 private:
  using Phases = std::array<T, 3>;

  static constexpr int passes = 2;

  struct Course {
    Phases i_begin;  ///< [A]
    Phases i_end;    ///< [A]
    T u_dc;          ///< [V]
    T duration;      ///< [s]
  };

  /// Currents and volt-seconds on the way through a pattern.
  struct Way {
    Phases i{};       ///< [A]
    Phases drift{};   ///< slopes of the currents by all but the inverter [A/s]
    Phases beyond{};  ///< ∫v dt beyond that of an ideal inverter [V·s]
  };
  /// Legs by `SwitchState::upper_switches`.
  struct Commanded {
    unsigned high;       ///< those that the pattern has high
    unsigned gate_high;  ///< those that the gate drivers have high
    unsigned dead;       ///< those that are off, or in their dead time
  };

  [[nodiscard]] static constexpr T seconds(std::int64_t ns) noexcept { return T(1e-9) * T(ns); }
  [[nodiscard]] static constexpr Phases phases(const ThreePhase<T>& x) noexcept { return {x.a, x.b, x.c}; }

  [[nodiscard]] static constexpr ThreePhase<T> without_common(const Phases& v) noexcept {
    const T mean = (v[0] + v[1] + v[2]) / T(3);
    return {v[0] - mean, v[1] - mean, v[2] - mean};
  }

  /// Through a pattern, by these slopes of the currents by all but the inverter. [A/s]
  [[nodiscard]] constexpr Way through(const GatePattern& applied, const Course& course, const Phases& drift,
                                      Legs& legs) const noexcept {
    Way way{course.i_begin, drift, {}};
    for (const GateSegment& segment : applied.segments()) {
      for (std::int32_t left_ns = segment.duration_ns; left_ns > 0;) {
        const SwitchState gates = timing_.command(segment.state, legs);
        std::int32_t part_ns = timing_.holds(legs, left_ns);
        Commanded now{segment.state.upper_switches(), gates.upper_switches(), gates.legs_off()};
        for (unsigned n = 0; n < 3; ++n) {
          if (legs.dead_ns[n] == 0) continue;
          part_ns = std::min(part_ns, legs.dead_ns[n]);
          now.dead |= 1U << n;
        }
        go(way, now, course.u_dc, seconds(part_ns));
        timing_.let_pass(part_ns, legs);
        left_ns -= part_ns;
      }
    }
    return way;
  }

  /// Over dt [s], in parts that end where a leg in its dead time stops its current. A stop may let another
  /// leg conduct again: three legs take seven parts at most.
  constexpr void go(Way& way, Commanded legs, T u_dc, T dt) const noexcept {
    if (legs.dead == 0) return go_driven(way, legs, u_dc, dt);
    constexpr int most_parts = 8;
    for (int part = 0; part < most_parts && dt > T(0); ++part) {
      unsigned held = 0;
      const Phases v = potentials(way, legs, u_dc, held);
      const T mean = (v[0] + v[1] + v[2]) / T(3);
      Phases slope{};
      T step = dt;
      unsigned stopped = 3;
      for (unsigned n = 0; n < 3; ++n) {
        if ((held >> n & 1U) != 0U) continue;
        slope[n] = inverse_leakage_ * (v[n] - mean) + way.drift[n];
        const bool falls = (legs.dead >> n & 1U) != 0U && way.i[n] * slope[n] < T(0);
        if (!falls) continue;
        const T to_zero = -way.i[n] / slope[n];
        if (!(to_zero < step)) continue;
        step = to_zero;
        stopped = n;
      }
      for (unsigned n = 0; n < 3; ++n) {
        const T end = n == stopped ? T(0) : way.i[n] + step * slope[n];
        const T commanded = (legs.high >> n & 1U) != 0U ? u_dc : T(0);
        way.beyond[n] += step * (v[n] - commanded - drop(way.i[n], end));
        way.i[n] = end;
      }
      // Currents add up to zero, so with two of them zero none flows.
      if (stopped < 3 && std::ranges::count(way.i, T(0)) == 2) way.i = {};
      dt -= step;
    }
  }

  /// The same where no leg is in its dead time: each is tied by its gates, and no current stops.
  constexpr void go_driven(Way& way, Commanded legs, T u_dc, T dt) const noexcept {
    Phases v{};
    for (unsigned n = 0; n < 3; ++n) v[n] = (legs.gate_high >> n & 1U) != 0U ? u_dc : T(0);
    const T mean = (v[0] + v[1] + v[2]) / T(3);
    for (unsigned n = 0; n < 3; ++n) {
      const T end = way.i[n] + dt * (inverse_leakage_ * (v[n] - mean) + way.drift[n]);
      const T commanded = (legs.high >> n & 1U) != 0U ? u_dc : T(0);
      way.beyond[n] += dt * (v[n] - commanded - drop(way.i[n], end));
      way.i[n] = end;
    }
  }

  /// Of the legs against the lower rail, without drops. held: legs whose current stays zero. [V]
  ///
  /// Legs in their dead time without current float. With e_x = σL_s d_x, minus the EMF of a phase, their
  /// potentials are s − e_x, s that of the star point: the sum of v_x − s + e_x over the tied legs is zero.
  /// Where that lies beyond a rail a diode ties the leg, the one furthest beyond first: what then ties others
  /// draws it back by half of how far they lie beyond, at most, so that it stays tied.
  [[nodiscard]] constexpr Phases potentials(const Way& way, Commanded legs, T u_dc,
                                            unsigned& held) const noexcept {
    Phases v{};
    Phases emf{};
    held = 0;
    for (unsigned n = 0; n < 3; ++n) {
      const bool is_dead = (legs.dead >> n & 1U) != 0U;
      const bool is_high = is_dead ? way.i[n] < T(0) : (legs.gate_high >> n & 1U) != 0U;
      v[n] = is_high ? u_dc : T(0);
      if (is_dead && way.i[n] == T(0)) held |= 1U << n;
    }
    if (held == 0) return v;
    for (std::size_t n = 0; n < 3; ++n) emf[n] = way.drift[n] / inverse_leakage_;
    while (held != 0) {
      const T star = star_point(v, emf, held, u_dc);
      unsigned furthest = 3;
      T most = T(0);
      for (unsigned n = 0; n < 3; ++n) {
        if ((held >> n & 1U) == 0U) continue;
        v[n] = star - emf[n];
        const T beyond = std::max(v[n] - u_dc, -v[n]);
        if (!(beyond > most)) continue;
        most = beyond;
        furthest = n;
      }
      if (furthest == 3) break;
      v[furthest] = v[furthest] > T(0) ? u_dc : T(0);
      held &= ~(1U << furthest);
    }
    return v;
  }

  /// Of the windings, while the currents of the held legs stay zero; where all three are, the potentials lie
  /// in the middle between the rails. [V]
  [[nodiscard]] static constexpr T star_point(const Phases& v, const Phases& emf, unsigned held,
                                              T u_dc) noexcept {
    constexpr unsigned all = 7;
    if (held == all) return T(0.5) * (u_dc + std::ranges::min(emf) + std::ranges::max(emf));
    T sum{};
    int tied = 0;
    for (unsigned n = 0; n < 3; ++n) {
      const bool is_held = (held >> n & 1U) != 0U;
      sum += is_held ? -emf[n] : v[n];
      tied += is_held ? 0 : 1;
    }
    return sum / T(tied);
  }

  /// Of a switch or diode while its current runs from one value to another. [V]
  [[nodiscard]] constexpr T drop(T from, T to) const noexcept {
    if (!has_drops_) return T(0);
    return parameters_.threshold_voltage * mean_sign(from, to) +
           parameters_.slope_resistance * T(0.5) * (from + to);
  }

  /// The slopes that with an ideal inverter lead to the currents at the end. [A/s]
  [[nodiscard]] constexpr Phases ideal_drift(const GatePattern& pattern,
                                             const Course& course) const noexcept {
    const Phases v = phases(inverse_clarke(volt_seconds(pattern, course.u_dc)));
    Phases out{};
    for (std::size_t n = 0; n < 3; ++n) {
      out[n] = (course.i_end[n] - course.i_begin[n] - inverse_leakage_ * v[n]) / course.duration;
    }
    return out;
  }

  /// Of the sign of a current that runs from one value to another in a line. [-]
  [[nodiscard]] static constexpr T mean_sign(T from, T to) noexcept {
    const auto size = [](T x) { return x < T(0) ? -x : x; };
    if (from >= T(0) && to >= T(0)) return from > T(0) || to > T(0) ? T(1) : T(0);
    if (from <= T(0) && to <= T(0)) return T(-1);
    return (size(to) - size(from)) / (to - from);
  }

  Parameters parameters_;
  LegTiming timing_;
  bool is_ideal_;
  bool has_drops_;     ///< threshold or slope
  T inverse_leakage_;  ///< 1/σL_s [1/H]
  Legs legs_{};
  Phases drift_{};     ///< slopes of the currents by all but the inverter, at the last measurement [A/s]
  ThreePhase<T> i_{};  ///< at the last measurement [A]
};

}  // namespace sextant
