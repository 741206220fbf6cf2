#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "sextant/control/admissible_pulse.hpp"
#include "sextant/control/pulse_times.hpp"
#include "sextant/control/voltage_hexagon.hpp"
#include "sextant/core/description.hpp"
#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/space_vector.hpp"
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

/// Space-vector modulation of a two-level inverter: the gate pattern of a period whose mean voltage is a
/// given vector, by the two active vectors beside it and the zero vectors. With the phase voltages sorted,
///   t_1 = (v_max − v_mid)/u_dc · t_period,   t_2 = (v_mid − v_min)/u_dc · t_period
/// are the times of the active vectors with one and with two legs high. Times are whole nanoseconds and fill
/// the period exactly.
///
/// Where pulses would be too short the zero vectors exchange some of their time (`PulseTimes`): the error of
/// the voltage is zero except near the edges of the hexagon. A voltage beyond it is that of `VoltageHexagon`.
///
/// Sources: H. W. van der Broeck, H.-C. Skudelny, G. V. Stanke, "Analysis and realization of a pulsewidth
/// modulator based on voltage space vectors", IEEE Trans. Ind. Appl. 24 (1988) 142–150; for the zero vectors
/// A. M. Hava, R. J. Kerkman, T. A. Lipo, "Simple analytical and graphical methods for carrier-based PWM-VSI
/// drives", IEEE Trans. Power Electron. 14 (1999) 49–61.
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
      : parameters_{parameters}, hexagon_{parameters.overmodulation}, times_{parameters.admissible()} {}

  /// The pattern of a period of period_ns with the mean voltage u [V], at the link voltage u_dc [V]; V0
  /// without link voltage. Beyond the hexagon the voltage is that of `within_hexagon`. `leg_correction`: time
  /// by which each leg is to be high longer, such as what the dead time takes from it; a leg that does not
  /// switch stays as it is. [s]
  [[nodiscard]] GatePattern step(SpaceVector<T> u, T u_dc, std::int32_t period_ns,
                                 ThreePhase<T> leg_correction = {}) noexcept {
    const ThreePhase<T> v = inverse_clarke(u);
    Order order = legs_by_voltage(v);
    const ActiveShares<T> shares = u_dc > T(0) ? hexagon_.shares(order, u_dc) : ActiveShares<T>{};
    const std::array<T, 3> correction{leg_correction.a, leg_correction.b, leg_correction.c};
    const typename PulseTimes<T>::Wanted wanted{
        high_times(shares, v, period_ns),
        {T(1e9) * correction[order.legs[0]], T(1e9) * correction[order.legs[1]],
         T(1e9) * correction[order.legs[2]]},
        period_ns};
    HighTimes high_ns = times_.nearest(wanted);
    sort(order, high_ns);
    return pattern(order, high_ns, period_ns);
  }

  /// Those of `VoltageHexagon`: the mean voltage of a pattern's period as it will be, that which a period is
  /// to have where u is demanded, and the fundamental of this while u turns. [V]
  [[nodiscard]] SpaceVector<T> within_hexagon(SpaceVector<T> u, T u_dc) const noexcept {
    return hexagon_.within_hexagon(u, u_dc);
  }
  [[nodiscard]] SpaceVector<T> mean_voltage(SpaceVector<T> u, T u_dc) const noexcept {
    return hexagon_.mean_voltage(u, u_dc);
  }
  [[nodiscard]] SpaceVector<T> fundamental(SpaceVector<T> u, T u_dc) const noexcept {
    return hexagon_.fundamental(u, u_dc);
  }
  [[nodiscard]] constexpr bool holds_fundamental() const noexcept { return hexagon_.holds_fundamental(); }
  [[nodiscard]] constexpr T longest(T u_dc) const noexcept { return hexagon_.longest(u_dc); }

  void reset() noexcept { falls_ = false; }

 private:
  using Order = LegOrder<T>;

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

  [[nodiscard]] HighTimes high_times(ActiveShares<T> s, const ThreePhase<T>& v,
                                     std::int32_t period_ns) const noexcept {
    const T period = T(period_ns);
    const std::int32_t two = nearest_ns(s.two * period, period_ns);
    const std::int32_t active = std::max(two, nearest_ns((s.one + s.two) * period, period_ns));
    const std::int32_t zero = period_ns - active;
    const std::int32_t all = nearest_ns(share_of_high(v) * T(zero), zero);
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
  VoltageHexagon<T> hexagon_;
  PulseTimes<T> times_;
  bool falls_{false};  ///< the coming asymmetric pattern begins with V7
};

}  // namespace sextant
