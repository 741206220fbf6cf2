#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <utility>

#include "sextant/control/admissible_pulse.hpp"
#include "sextant/core/description.hpp"
#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/steady_state.hpp"
#include "sextant/core/switch_state.hpp"

namespace sextant {

/// How the active vectors stand in a period.
enum class PatternKind : std::uint8_t {
  symmetric,  ///< about its middle: each modulated leg goes high and low in every period
  asymmetric  ///< each modulated leg switches once a period, up and down in turn: half the switching
              ///< frequency
};

/// Which zero vector fills what the active vectors leave of a period.
enum class ZeroVectors : std::uint8_t {
  both,        ///< V0 and V7 for the same time (continuous space-vector modulation)
  low,         ///< V0: the leg with the lowest voltage stays low (DPWMMIN)
  high,        ///< V7: the leg with the highest voltage stays high (DPWMMAX)
  alternating  ///< the leg with the largest voltage of either sign stays where it is (DPWM1)
};

/// Which voltage takes the place of one beyond the hexagon.
enum class Overmodulation : std::uint8_t {
  angle,       ///< the one in the same direction
  magnitude,   ///< the nearest one: up to six-step, as the voltage grows
  fundamental  ///< as it turns, those of which it is the fundamental: up to six-step at 2/π u_dc
};

/// Space-vector modulation of a two-level inverter: the gate pattern of a period whose mean voltage is a
/// given vector, by the two active vectors beside it and the zero vectors. With the phase voltages sorted,
///   t_1 = (v_max − v_mid)/u_dc · t_period,   t_2 = (v_mid − v_min)/u_dc · t_period
/// are the times of the active vectors with one and with two legs high. Times are whole nanoseconds and fill
/// the period exactly.
///
/// Where pulses would be too short both zero vectors exchange some of their time, which moves the high times
/// of all legs alike and leaves the voltage as it is: as little as suffices, up to a leg that rests; where
/// nothing suffices, by what leaves the smallest error of the voltage between two legs, each at the nearest
/// time for which it can be high. So the error is zero except near the edges of the hexagon.
///
/// `Overmodulation::fundamental`: while u turns, the circle within the hexagon, the hexagon and its corners
/// are three courses of the voltage in phase with u, with the fundamentals
///   u_dc/√3,   √3 ln 3/π u_dc = 0.606 u_dc,   2/π u_dc = 0.637 u_dc
/// Between two of them stands the mean of both, weighted so that its fundamental is u. It is within the
/// hexagon, because that is convex: mode I with pulses at all angles, mode II along the edges with rests at
/// the corners, to six-step.
///
/// Sources: H. W. van der Broeck, H.-C. Skudelny, G. V. Stanke, "Analysis and realization of a pulsewidth
/// modulator based on voltage space vectors", IEEE Trans. Ind. Appl. 24 (1988) 142–150; for the zero vectors
/// A. M. Hava, R. J. Kerkman, T. A. Lipo, "Simple analytical and graphical methods for carrier-based PWM-VSI
/// drives", IEEE Trans. Power Electron. 14 (1999) 49–61; for the two modes J. Holtz, W. Lotzkat, A. M.
/// Khambadkone, "On continuous control of PWM inverters in the overmodulation range including the six-step
/// mode", IEEE Trans. Power Electron. 8 (1993) 546–553, who reach the fundamental by tables of magnitude and
/// hold angle.
template <class T = double>
class SpaceVectorModulator {
 public:
  struct Parameters {
    PatternKind pattern{PatternKind::symmetric};
    ZeroVectors zero_vectors{ZeroVectors::both};
    Overmodulation overmodulation{Overmodulation::magnitude};
    /// A leg is high, and low, for no shorter time in a period, or not at all [ns]
    std::int32_t shortest_pulse_ns{0};
    /// Of the inverter: what is shorter, in one period or in two that follow each other, does not act as
    /// commanded [ns]
    std::int32_t minimum_pulse_ns{0};

    /// Without what is the inverter's.
    friend void describe(Description& d, Parameters& p) {
      auto& [kind, zeros, beyond, shortest_ns, of_inverter_ns] = p;
      (void)of_inverter_ns;
      d.choice(
          "pattern", kind, {{"symmetric", PatternKind::symmetric}, {"asymmetric", PatternKind::asymmetric}},
          "each modulated leg switches twice a period, about its middle; or once, which halves the switching "
          "frequency");
      d.choice("zero_vectors", zeros,
               {{"both", ZeroVectors::both},
                {"low", ZeroVectors::low},
                {"high", ZeroVectors::high},
                {"alternating", ZeroVectors::alternating}},
               "both for the same time; V0 or V7 alone; or the one with which the leg of the largest voltage "
               "does not switch; another share of both where a pulse would be too short");
      d.choice("overmodulation", beyond,
               {{"magnitude", Overmodulation::magnitude},
                {"angle", Overmodulation::angle},
                {"fundamental", Overmodulation::fundamental}},
               "in the place of a voltage beyond the inverter's hexagon the nearest one, up to six-step, or "
               "the one in the same direction; or from u_dc/sqrt(3) on those of which it is the fundamental, "
               "up to six-step, for capability.voltage_use above 1");
      d.time("shortest_pulse_us", shortest_ns,
             in_us(0, 1000,
                   "shortest time for which a leg is high, or low, in a period; a shorter one is left out or "
                   "lengthened where no share of the zero vectors avoids it; what the inverter needs follows "
                   "from drive.inverter.minimum_pulse_us by itself"));
    }

    [[nodiscard]] const char* validate() const noexcept {
      if (minimum_pulse_ns < 0) return "the inverter's minimum pulse must not be below zero";
      return shortest_pulse_ns >= 0 ? nullptr : "the shortest pulse must not be below zero";
    }
    /// Of both.
    [[nodiscard]] constexpr AdmissiblePulse admissible() const noexcept {
      const AdmissiblePulse acting = pattern == PatternKind::symmetric
                                         ? AdmissiblePulse::symmetric(minimum_pulse_ns)
                                         : AdmissiblePulse::one_edge(minimum_pulse_ns);
      return {std::max(shortest_pulse_ns, acting.shortest_high_ns),
              std::max(shortest_pulse_ns, acting.shortest_low_ns)};
    }
  };

  constexpr explicit SpaceVectorModulator(const Parameters& parameters) noexcept
      : parameters_{parameters}, admissible_{parameters.admissible()} {}

  /// The pattern of a period of period_ns with the mean voltage u [V], at the link voltage u_dc [V]; V0
  /// without link voltage. Beyond the hexagon the voltage is that of `within_hexagon`. `leg_correction`: time
  /// by which each leg is to be high longer, such as what the dead time takes from it; a leg that does not
  /// switch stays as it is. [s]
  [[nodiscard]] GatePattern step(SpaceVector<T> u, T u_dc, std::int32_t period_ns,
                                 ThreePhase<T> leg_correction = {}) noexcept {
    const ThreePhase<T> v = inverse_clarke(u);
    Order order = sorted(v);
    const Shares shares = u_dc > T(0) ? within_period(order, u_dc) : Shares{};
    const std::array<T, 3> correction{leg_correction.a, leg_correction.b, leg_correction.c};
    const Wanted wanted{high_times(shares, v, period_ns),
                        {T(1e9) * correction[order.legs[0]], T(1e9) * correction[order.legs[1]],
                         T(1e9) * correction[order.legs[2]]},
                        period_ns};
    HighTimes high_ns = admissible_.acts() ? best(wanted) : realised(wanted, 0);
    sort(order, high_ns);
    return pattern(order, high_ns, period_ns);
  }

  /// The mean voltage of a pattern's period as it will be: u, or what takes its place. [V]
  [[nodiscard]] SpaceVector<T> within_hexagon(SpaceVector<T> u, T u_dc) const noexcept {
    if (!(u_dc > T(0))) return {};
    const Order order = sorted(inverse_clarke(u));
    return mean_of(within_period(order, u_dc), order, u_dc);
  }

  /// The mean voltage that a period is to have where u is demanded: within the hexagon, and beyond the circle
  /// in it with `Overmodulation::fundamental` that of which u is the fundamental. [V]
  [[nodiscard]] SpaceVector<T> mean_voltage(SpaceVector<T> u, T u_dc) const noexcept {
    if (!holds_fundamental() || !(u_dc > T(0))) return within_hexagon(u, u_dc);
    const Order order = sorted(inverse_clarke(u));
    return mean_of(with_fundamental(order, u_dc), order, u_dc);
  }
  /// True where the voltage has harmonics so that its fundamental is the one demanded.
  [[nodiscard]] constexpr bool holds_fundamental() const noexcept {
    return parameters_.overmodulation == Overmodulation::fundamental;
  }
  /// The fundamental of `mean_voltage` while u turns: u, up to that of six-step; with the other kinds of
  /// over-modulation that of the one period. [V]
  [[nodiscard]] SpaceVector<T> fundamental(SpaceVector<T> u, T u_dc) const noexcept {
    if (!holds_fundamental()) return within_hexagon(u, u_dc);
    const T square = dot(u, u);
    if (!(u_dc > T(0)) || !(square < std::numeric_limits<T>::infinity())) return {};
    const T most = longest(u_dc);
    return square <= most * most ? u : (most / std::sqrt(square)) * u;
  }

  /// The longest voltage that `fundamental` leaves as it is in every direction. [V]
  [[nodiscard]] constexpr T longest(T u_dc) const noexcept {
    return holds_fundamental() ? six_step * linear_voltage(u_dc) : linear_voltage(u_dc);
  }

  void reset() noexcept { falls_ = false; }

 private:
  /// Legs by falling voltage, with their voltages [V].
  struct Order {
    std::array<std::size_t, 3> legs;
    std::array<T, 3> volts;
  };
  /// Times of the active vectors with one and with two legs high, by the period. [-]
  struct Shares {
    T one{};
    T two{};
  };
  using HighTimes = std::array<std::int32_t, 3>;  ///< of the legs by falling voltage [ns]

  [[nodiscard]] static constexpr Order sorted(const ThreePhase<T>& v) noexcept {
    Order o{{0, 1, 2}, {v.a, v.b, v.c}};
    const auto compare = [&o](std::size_t n, std::size_t k) {
      if (!(o.volts[n] < o.volts[k])) return;
      std::swap(o.volts[n], o.volts[k]);
      std::swap(o.legs[n], o.legs[k]);
    };
    compare(0, 1);
    compare(1, 2);
    compare(0, 1);
    return o;
  }

  /// A correction may make the leg of a lower voltage high for longer.
  static constexpr void sort(Order& o, HighTimes& high_ns) noexcept {
    const auto compare = [&o, &high_ns](std::size_t n, std::size_t k) {
      if (high_ns[n] >= high_ns[k]) return;
      std::swap(high_ns[n], high_ns[k]);
      std::swap(o.legs[n], o.legs[k]);
    };
    compare(0, 1);
    compare(1, 2);
    compare(0, 1);
  }

  [[nodiscard]] Shares within_period(const Order& o, T u_dc) const noexcept {
    const T one = (o.volts[0] - o.volts[1]) / u_dc;
    const T two = (o.volts[1] - o.volts[2]) / u_dc;
    const T sum = one + two;
    if (!(sum < std::numeric_limits<T>::infinity())) return {};  // no voltage at all
    if (sum <= T(1)) return {one, two};
    if (parameters_.overmodulation == Overmodulation::angle) return {one / sum, two / sum};
    const T nearest = std::clamp(one - T(0.5) * (sum - T(1)), T(0), T(1));
    return {nearest, T(1) - nearest};
  }

  /// Fundamentals by u_dc/√3, of the hexagon's course and of its corners'. [-]
  static constexpr T hexagon = T(1.0490974577);  // 3 ln 3/π
  static constexpr T six_step = six_step_share<T>;

  /// Of the course of which these voltages are the fundamental.
  [[nodiscard]] static Shares with_fundamental(const Order& o, T u_dc) noexcept {
    const Shares s{(o.volts[0] - o.volts[1]) / u_dc, (o.volts[1] - o.volts[2]) / u_dc};
    const T sum = s.one + s.two;
    if (!(sum < std::numeric_limits<T>::infinity())) return {};  // no voltage at all
    const T square = T(4) / T(3) * (s.one * s.one + s.one * s.two + s.two * s.two);
    if (square <= T(1)) return s;
    const T rho = std::sqrt(square);
    const Shares edge{s.one / sum, s.two / sum};
    if (rho < hexagon) return between({s.one / rho, s.two / rho}, edge, (rho - T(1)) / (hexagon - T(1)));
    const Shares corner = s.one < s.two ? Shares{T(0), T(1)} : Shares{T(1), T(0)};
    return between(edge, corner, std::min(T(1), (rho - hexagon) / (six_step - hexagon)));
  }
  /// The mean of both, of the second with this weight. [-]
  [[nodiscard]] static constexpr Shares between(Shares a, Shares b, T weight) noexcept {
    return {a.one + weight * (b.one - a.one), a.two + weight * (b.two - a.two)};
  }

  [[nodiscard]] static SpaceVector<T> mean_of(Shares s, const Order& o, T u_dc) noexcept {
    std::array<T, 3> legs{};
    legs[o.legs[0]] = s.one + s.two;
    legs[o.legs[1]] = s.two;
    return u_dc * clarke(ThreePhase<T>{legs[0], legs[1], legs[2]});
  }

  [[nodiscard]] HighTimes high_times(Shares s, const ThreePhase<T>& v,
                                     std::int32_t period_ns) const noexcept {
    const T period = T(period_ns);
    const std::int32_t two = to_ns(s.two * period, period_ns);
    const std::int32_t active = std::max(two, to_ns((s.one + s.two) * period, period_ns));
    const std::int32_t zero = period_ns - active;
    const std::int32_t all = to_ns(share_of_high(v) * T(zero), zero);
    return {all + active, all + two, all};
  }

  /// Time of V7 by that of both zero vectors. [-]
  [[nodiscard]] T share_of_high(const ThreePhase<T>& v) const noexcept {
    switch (parameters_.zero_vectors) {
      case ZeroVectors::low:
        return T(0);
      case ZeroVectors::high:
        return T(1);
      case ZeroVectors::alternating:
        return std::max({v.a, v.b, v.c}) + std::min({v.a, v.b, v.c}) > T(0) ? T(1) : T(0);
      case ZeroVectors::both:
        break;
    }
    return T(0.5);
  }

  /// Within [0, most]; 0 for no number.
  [[nodiscard]] static std::int32_t to_ns(T ns, std::int32_t most) noexcept {
    return ns > T(0) ? std::int32_t(std::min(ns + T(0.5), T(most))) : 0;
  }

  /// What the legs are to be high for, by falling voltage.
  struct Wanted {
    HighTimes ideal_ns;          ///< without correction
    std::array<T, 3> longer_ns;  ///< where the leg switches [ns]
    std::int32_t period_ns;
    [[nodiscard]] constexpr bool rests(std::int32_t high_ns) const noexcept {
      return high_ns == 0 || high_ns == period_ns;
    }
  };

  /// Each leg at its nearest admissible time, where all are high longer by `shift_ns`; a leg that then rests
  /// stays as it is.
  [[nodiscard]] HighTimes realised(const Wanted& wanted, std::int32_t shift_ns) const noexcept {
    HighTimes high_ns{};
    for (std::size_t n = 0; n < 3; ++n) {
      const std::int32_t ideal_ns = wanted.ideal_ns[n] + shift_ns;
      high_ns[n] = wanted.rests(ideal_ns)
                       ? ideal_ns
                       : admissible_.nearest(to_ns(T(ideal_ns) + wanted.longer_ns[n], wanted.period_ns),
                                             wanted.period_ns);
    }
    return high_ns;
  }

  /// The largest difference between two legs of what these times miss, with the same shift. [ns]
  [[nodiscard]] static std::int32_t error(const Wanted& wanted, std::int32_t shift_ns,
                                          const HighTimes& high_ns) noexcept {
    std::array<std::int32_t, 3> missed{};
    for (std::size_t n = 0; n < 3; ++n) {
      const std::int32_t ideal_ns = wanted.ideal_ns[n] + shift_ns;
      if (wanted.rests(ideal_ns)) continue;
      missed[n] = due_ns(wanted, n, shift_ns) - high_ns[n];
    }
    return std::max({missed[0], missed[1], missed[2]}) - std::min({missed[0], missed[1], missed[2]});
  }

  /// With the smallest error; of several the one with the zero vectors nearest to those demanded. But for
  /// these a leg rests, or is at an end of its admissible times: between such shifts the legs that miss their
  /// times do so by the same difference.
  [[nodiscard]] HighTimes best(const Wanted& wanted) const noexcept {
    Best found{realised(wanted, 0), 0, 0};
    found.error_ns = error(wanted, 0, found.high_ns);
    if (found.error_ns == 0) return found.high_ns;
    consider(wanted, -wanted.ideal_ns[2], found);
    consider(wanted, wanted.period_ns - wanted.ideal_ns[0], found);
    for (std::size_t n = 0; n < 3; ++n) {
      const std::int32_t due = due_ns(wanted, n, 0);
      consider(wanted, admissible_.shortest_high_ns - due, found);
      consider(wanted, wanted.period_ns - admissible_.shortest_low_ns - due, found);
    }
    return found.high_ns;
  }

  struct Best {
    HighTimes high_ns;
    std::int32_t error_ns;
    std::int32_t shift_ns;
  };
  void consider(const Wanted& wanted, std::int32_t shift_ns, Best& found) const noexcept {
    if (shift_ns < -wanted.ideal_ns[2] || shift_ns > wanted.period_ns - wanted.ideal_ns[0]) return;
    const HighTimes high_ns = realised(wanted, shift_ns);
    const std::int32_t error_ns = error(wanted, shift_ns, high_ns);
    if (error_ns > found.error_ns) return;
    if (error_ns == found.error_ns && std::abs(shift_ns) >= std::abs(found.shift_ns)) return;
    found = {high_ns, error_ns, shift_ns};
  }

  /// What a leg that switches is to be high for, up to a period beyond both ends of the period. [ns]
  [[nodiscard]] static std::int32_t due_ns(const Wanted& wanted, std::size_t n,
                                           std::int32_t shift_ns) noexcept {
    const T due = T(wanted.ideal_ns[n] + shift_ns) + wanted.longer_ns[n];
    return to_ns(due, wanted.period_ns) - beyond(due, wanted.period_ns);
  }

  /// By how much a time lies below zero, or above the period as a number below zero. [ns]
  [[nodiscard]] static std::int32_t beyond(T ns, std::int32_t period_ns) noexcept {
    return ns < T(0) ? to_ns(-ns, period_ns) : -to_ns(ns - T(period_ns), period_ns);
  }

  [[nodiscard]] GatePattern pattern(const Order& o, const HighTimes& high_ns,
                                    std::int32_t period_ns) noexcept {
    std::array<SwitchState, 4> states{};  // with none, one, two and all legs high
    std::array<LegState, 3> legs{LegState::low, LegState::low, LegState::low};
    states[0] = {legs[0], legs[1], legs[2]};
    for (std::size_t n = 0; n < 3; ++n) {
      legs[o.legs[n]] = LegState::high;
      states[n + 1] = {legs[0], legs[1], legs[2]};
    }
    const std::array<std::int32_t, 4> times{period_ns - high_ns[0], high_ns[0] - high_ns[1],
                                            high_ns[1] - high_ns[2], high_ns[2]};
    return parameters_.pattern == PatternKind::symmetric ? symmetric(states, times)
                                                         : asymmetric(states, times);
  }

  using States = std::array<SwitchState, 4>;
  using Times = std::array<std::int32_t, 4>;

  /// Halves of the first three states around the last.
  [[nodiscard]] static GatePattern symmetric(const States& states, const Times& times) noexcept {
    GatePattern p;
    for (std::size_t n = 0; n < 3; ++n) append(p, states[n], times[n] / 2);
    append(p, states[3], times[3]);
    for (std::size_t n = 3; n-- > 0;) append(p, states[n], times[n] - times[n] / 2);
    return p;
  }

  /// From V0 to V7, and in the next period back.
  [[nodiscard]] GatePattern asymmetric(const States& states, const Times& times) noexcept {
    GatePattern p;
    for (std::size_t n = 0; n < 4; ++n) {
      const std::size_t k = falls_ ? 3 - n : n;
      append(p, states[k], times[k]);
    }
    falls_ = !falls_;
    return p;
  }

  static void append(GatePattern& p, SwitchState state, std::int32_t duration_ns) noexcept {
    if (duration_ns > 0) p.append({state, duration_ns});
  }

  Parameters parameters_;
  AdmissiblePulse admissible_;
  bool falls_{false};  ///< the coming asymmetric pattern begins with V7
};

}  // namespace sextant
