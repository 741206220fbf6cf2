#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"
#include "sextant/core/two_level_inverter.hpp"

namespace sextant {

/// The inverter as the drive takes it to be: by how much the volt-seconds of each leg differ from those of
/// the commanded pattern.
///
/// Dead time. Where a leg changes between low and high both of its switches are off for t_d. Its potential v
/// is then 0 while i_x > 0 and u_dc while i_x < 0, by the diodes; where the current reaches zero it stays
/// there, and v is what keeps it:
///   di_x/dt = (u_x(v) − e_x)/σL_s = 0,   u_x(v) = u_x(0) + 2/3 v,   0 ≤ v ≤ u_dc
/// so that a leg whose current keeps its sign loses sign(i_x) u_dc t_d in a period of two changes. Drops: a
/// switch or diode that carries i_x takes (V_t + r |i_x|) sign(i_x).
///
/// The sign of a current near zero follows from its course between the readings at both ends, with the ripple
/// of the pattern by the leakage:
///   i(t) = i_begin + V(t)/σL_s + t/T (i_end − i_begin − V(T)/σL_s),   V(t) = ∫u_x dt
/// where the last term is what EMF and resistance change. V is that of the acted volt-seconds, which are
/// found in two passes: the first takes those of the commanded pattern for V(T). Sources: S.-G. Jeong, M.-H.
/// Park, "The analysis and compensation of dead-time effects in PWM inverters", IEEE Trans. Ind. Electron. 38
/// (1991) 108–114; for the drops A. R. Muñoz, T. A. Lipo, "On-line dead-time compensation technique for
/// open-loop PWM-VSI drives", IEEE Trans. Power Electron. 14 (1999) 683–689.
///
/// Not in the model: switching times, the minimum pulse, and currents that are read wrong by as much as they
/// change within a period.
template <class T = double>
class InverterModel {
 public:
  /// All zero: an ideal inverter.
  struct Parameters {
    std::int32_t dead_time_ns{0};  ///< t_d [ns]
    T threshold_voltage{};         ///< V_t, of a switch or diode that conducts [V]
    T slope_resistance{};          ///< r, the same [Ω]

    [[nodiscard]] constexpr bool is_ideal() const noexcept {
      return dead_time_ns == 0 && threshold_voltage == T(0) && slope_resistance == T(0);
    }
    /// For a control period. [ns]
    [[nodiscard]] const char* validate(std::int32_t period_ns) const noexcept {
      if (dead_time_ns < 0 || dead_time_ns >= period_ns - dead_time_ns) {
        return "the inverter's dead time must be from zero to below half of the control period";
      }
      const auto is_usable = [](T x) { return std::isfinite(x) && x >= T(0); };
      if (!is_usable(threshold_voltage)) return "the inverter's threshold voltage must not be below zero";
      return is_usable(slope_resistance) ? nullptr : "the inverter's slope resistance must not be below zero";
    }
  };

  /// What the legs bring along into an interval.
  struct Legs {
    SwitchState commanded{gates_off};
    std::array<std::int32_t, 3> dead_ns{};  ///< what is left of their dead times [ns]
  };

  /// leakage: σL_s of the machine. [H]
  constexpr InverterModel(const Parameters& parameters, T leakage) noexcept
      : parameters_{parameters}, is_ideal_{parameters.is_ideal()}, inverse_leakage_{T(1) / leakage} {}

  [[nodiscard]] constexpr bool is_ideal() const noexcept { return is_ideal_; }
  /// The legs at the last measurement.
  [[nodiscard]] constexpr const Legs& legs() const noexcept { return legs_; }

  /// The measurement at the end of an applied pattern, with the phase currents [A] and the link voltage [V];
  /// each one, in order. ∫u_x dt beyond that of an ideal inverter; zero where a leg was off. [V·s]
  [[nodiscard]] constexpr ThreePhase<T> step(const GatePattern& applied, const ThreePhase<T>& i,
                                             T u_dc) noexcept {
    if (is_ideal_) return {};
    const Course course{phases(i_), phases(i), u_dc, seconds(applied.duration_ns())};
    i_ = i;
    if (!applied.is_driven() || applied.duration_ns() == 0) {
      pass(applied, legs_);
      return {};
    }
    Legs first = legs_;
    const Phases guess = deviation(applied, course, {}, first);
    return without_common(deviation(applied, course, guess, legs_));
  }

  /// The same of each leg's own potential for a pattern to come, in which every leg is driven, from these
  /// legs on, which are left as they are at its end. i: currents at its beginning, and at its end as an ideal
  /// inverter would make them. [V·s]
  [[nodiscard]] constexpr ThreePhase<T> predicted(const GatePattern& pattern, SpaceVector<T> i_begin,
                                                  SpaceVector<T> i_end, T u_dc, Legs& legs) const noexcept {
    const Course course{phases(inverse_clarke(i_begin)), phases(inverse_clarke(i_end)), u_dc,
                        seconds(pattern.duration_ns())};
    const Phases v = deviation(pattern, course, {}, legs);
    return {v[0], v[1], v[2]};
  }

  /// The legs go through a pattern.
  constexpr void pass(const GatePattern& pattern, Legs& legs) const noexcept {
    for (const GateSegment& segment : pattern.segments()) {
      command(segment.state, legs);
      for (std::int32_t& dead_ns : legs.dead_ns) dead_ns = std::max(0, dead_ns - segment.duration_ns);
    }
  }

 private:
  using Phases = std::array<T, 3>;

  struct Course {
    Phases i_begin;  ///< [A]
    Phases i_end;    ///< [A]
    T u_dc;          ///< [V]
    T duration;      ///< [s]
  };

  /// One leg in a segment.
  struct Leg {
    bool is_high;
    T i;      ///< at its beginning [A]
    T slope;  ///< of the current, as commanded [A/s]
  };

  [[nodiscard]] static constexpr T seconds(std::int64_t ns) noexcept { return T(1e-9) * T(ns); }
  [[nodiscard]] static constexpr Phases phases(const ThreePhase<T>& x) noexcept { return {x.a, x.b, x.c}; }

  [[nodiscard]] static constexpr ThreePhase<T> without_common(const Phases& v) noexcept {
    const T mean = (v[0] + v[1] + v[2]) / T(3);
    return {v[0] - mean, v[1] - mean, v[2] - mean};
  }

  constexpr void command(SwitchState state, Legs& legs) const noexcept {
    const SwitchState before = legs.commanded;
    if (state == before) return;
    const unsigned changes = (before.upper_switches() ^ state.upper_switches()) | state.legs_off();
    for (unsigned n = 0; n < 3; ++n) {
      const bool was_driven = (before.legs_off() >> n & 1U) == 0U;
      if (was_driven && (changes >> n & 1U) != 0U) legs.dead_ns[n] = parameters_.dead_time_ns;
    }
    legs.commanded = state;
  }

  /// ∫v dt of each leg beyond an ideal one's. `guess`: the same over the whole course, as far as it is known.
  [[nodiscard]] constexpr Phases deviation(const GatePattern& applied, const Course& course,
                                           const Phases& guess, Legs& legs) const noexcept {
    const Phases rest = drift(applied, course, guess);
    Phases i = course.i_begin;
    Phases sum{};
    for (const GateSegment& segment : applied.segments()) {
      command(segment.state, legs);
      const T dt = seconds(segment.duration_ns);
      const Phases u = phases(inverse_clarke(stator_voltage(segment.state, course.u_dc)));
      Phases beyond{};
      for (std::size_t n = 0; n < 3; ++n) {
        const bool is_high = (segment.state.upper_switches() >> n & 1U) != 0U;
        beyond[n] = of_leg({is_high, i[n], inverse_leakage_ * u[n] + rest[n]}, course.u_dc, dt,
                           seconds(std::min(legs.dead_ns[n], segment.duration_ns)));
        legs.dead_ns[n] = std::max(0, legs.dead_ns[n] - segment.duration_ns);
        sum[n] += beyond[n];
      }
      const Phases acted = phases(without_common(beyond));
      for (std::size_t n = 0; n < 3; ++n) {
        i[n] += inverse_leakage_ * (dt * u[n] + acted[n]) + dt * rest[n];
      }
    }
    return sum;
  }

  /// Slopes of the currents by all but the inverter. [A/s]
  [[nodiscard]] constexpr Phases drift(const GatePattern& applied, const Course& course,
                                       const Phases& guess) const noexcept {
    const Phases ideal = phases(inverse_clarke(volt_seconds(applied, course.u_dc)));
    const Phases beyond = phases(without_common(guess));
    Phases out{};
    for (std::size_t n = 0; n < 3; ++n) {
      const T by_inverter = inverse_leakage_ * (ideal[n] + beyond[n]);
      out[n] = (course.i_end[n] - course.i_begin[n] - by_inverter) / course.duration;
    }
    return out;
  }

  /// One leg over a segment of dt [s], for the first `dead` [s] of which both switches are off. [V·s]
  [[nodiscard]] constexpr T of_leg(const Leg& leg, T u_dc, T dt, T dead) const noexcept {
    const T end = leg.i + dt * leg.slope;
    const T drop = parameters_.threshold_voltage * mean_sign(leg.i, end) +
                   parameters_.slope_resistance * T(0.5) * (leg.i + end);
    const T commanded = leg.is_high ? u_dc : T(0);
    return dead > T(0) ? diode_volt_seconds(leg, u_dc, dead) - dead * commanded - dt * drop : -dt * drop;
  }

  /// ∫v dt over a dead time.
  [[nodiscard]] constexpr T diode_volt_seconds(const Leg& leg, T u_dc, T dead) const noexcept {
    const T per_volt = T(2) / T(3) * inverse_leakage_;
    const T low = leg.slope - (leg.is_high ? per_volt * u_dc : T(0));
    const T high = low + per_volt * u_dc;
    const T floating = std::clamp(-low / per_volt, T(0), u_dc);
    const T potential = leg.i > T(0) ? T(0) : u_dc;
    const T slope = leg.i > T(0) ? -low : high;  // towards zero
    const T size = leg.i > T(0) ? leg.i : -leg.i;
    const T flows = slope * dead > size ? size / slope : dead;
    return flows * potential + (dead - flows) * floating;
  }

  /// Of the sign of a current that runs from one value to another in a line. [-]
  [[nodiscard]] static constexpr T mean_sign(T from, T to) noexcept {
    const auto size = [](T x) { return x < T(0) ? -x : x; };
    const T difference = to - from;
    if (difference == T(0)) return from > T(0) ? T(1) : from < T(0) ? T(-1) : T(0);
    return (size(to) - size(from)) / difference;
  }

  Parameters parameters_;
  bool is_ideal_;
  T inverse_leakage_;  ///< 1/σL_s [1/H]
  Legs legs_{};
  ThreePhase<T> i_{};  ///< at the last measurement [A]
};

}  // namespace sextant
