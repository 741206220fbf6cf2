#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "sextant/core/space_vector.hpp"
#include "sextant/core/steady_state.hpp"

namespace sextant {

/// Which voltage takes the place of one beyond the hexagon.
enum class Overmodulation : std::uint8_t {
  angle,       ///< the one in the same direction
  magnitude,   ///< the nearest one: up to six-step, as the voltage grows
  fundamental  ///< as it turns, those of which it is the fundamental: up to six-step at 2/π u_dc
};

/// Legs by falling voltage, with their voltages [V].
template <class T>
struct LegOrder {
  std::array<std::size_t, 3> legs;
  std::array<T, 3> volts;
};

/// Times of the active vectors with one and with two legs high, by the period. [-]
template <class T>
struct ActiveShares {
  T one{};
  T two{};
};

/// The legs of these voltages [V].
template <class T>
[[nodiscard]] constexpr LegOrder<T> legs_by_voltage(const ThreePhase<T>& v) noexcept {
  LegOrder<T> o{{0, 1, 2}, {v.a, v.b, v.c}};
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

/// The hexagon of the mean voltages that a two-level inverter can make in a period, and what takes the place
/// of a voltage beyond it.
///
/// `Overmodulation::fundamental`: while u turns, the circle within the hexagon, the hexagon and its corners
/// are three courses of the voltage in phase with u, with the fundamentals
///   u_dc/√3,   √3 ln 3/π u_dc = 0.606 u_dc,   2/π u_dc = 0.637 u_dc
/// Between two of them stands the mean of both, weighted so that its fundamental is u. It is within the
/// hexagon, because that is convex: mode I with pulses at all angles, mode II along the edges with rests at
/// the corners, to six-step.
/// Source: J. Holtz, W. Lotzkat, A. M. Khambadkone, "On continuous control of PWM inverters in the
/// overmodulation range including the six-step mode", IEEE Trans. Power Electron. 8 (1993) 546–553, who reach
/// the fundamental by tables of magnitude and hold angle.
template <class T = double>
class VoltageHexagon {
 public:
  constexpr explicit VoltageHexagon(Overmodulation overmodulation) noexcept
      : overmodulation_{overmodulation} {}

  /// The shares of the active vectors for these voltages [V], or for what takes their place in this one
  /// period.
  /// [-]
  [[nodiscard]] ActiveShares<T> shares(const LegOrder<T>& o, T u_dc) const noexcept {
    const T one = (o.volts[0] - o.volts[1]) / u_dc;
    const T two = (o.volts[1] - o.volts[2]) / u_dc;
    const T sum = one + two;
    if (!(sum < std::numeric_limits<T>::infinity())) return {};  // no voltage at all
    if (sum <= T(1)) return {one, two};
    if (overmodulation_ == Overmodulation::angle) return {one / sum, two / sum};
    const T nearest = std::clamp(one - T(0.5) * (sum - T(1)), T(0), T(1));
    return {nearest, T(1) - nearest};
  }

  /// The mean voltage of a pattern's period as it will be: u, or what takes its place. [V]
  [[nodiscard]] SpaceVector<T> within_hexagon(SpaceVector<T> u, T u_dc) const noexcept {
    if (!(u_dc > T(0))) return {};
    const LegOrder<T> order = legs_by_voltage(inverse_clarke(u));
    return mean_of(shares(order, u_dc), order, u_dc);
  }

  /// The mean voltage that a period is to have where u is demanded: within the hexagon, and beyond the circle
  /// in it with `Overmodulation::fundamental` that of which u is the fundamental. [V]
  [[nodiscard]] SpaceVector<T> mean_voltage(SpaceVector<T> u, T u_dc) const noexcept {
    if (!holds_fundamental() || !(u_dc > T(0))) return within_hexagon(u, u_dc);
    const LegOrder<T> order = legs_by_voltage(inverse_clarke(u));
    return mean_of(with_fundamental(order, u_dc), order, u_dc);
  }
  /// True where the voltage has harmonics so that its fundamental is the one demanded.
  [[nodiscard]] constexpr bool holds_fundamental() const noexcept {
    return overmodulation_ == Overmodulation::fundamental;
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

 private:
  /// Fundamentals by u_dc/√3, of the hexagon's course and of its corners'. [-]
  static constexpr T hexagon = T(1.0490974577);  // 3 ln 3/π
  static constexpr T six_step = six_step_share<T>;

  /// Of the course of which these voltages are the fundamental.
  [[nodiscard]] static ActiveShares<T> with_fundamental(const LegOrder<T>& o, T u_dc) noexcept {
    const ActiveShares<T> s{(o.volts[0] - o.volts[1]) / u_dc, (o.volts[1] - o.volts[2]) / u_dc};
    const T sum = s.one + s.two;
    if (!(sum < std::numeric_limits<T>::infinity())) return {};  // no voltage at all
    const T square = T(4) / T(3) * (s.one * s.one + s.one * s.two + s.two * s.two);
    if (square <= T(1)) return s;
    const T rho = std::sqrt(square);
    const ActiveShares<T> edge{s.one / sum, s.two / sum};
    if (rho < hexagon) return between({s.one / rho, s.two / rho}, edge, (rho - T(1)) / (hexagon - T(1)));
    const ActiveShares<T> corner = s.one < s.two ? ActiveShares<T>{T(0), T(1)} : ActiveShares<T>{T(1), T(0)};
    return between(edge, corner, std::min(T(1), (rho - hexagon) / (six_step - hexagon)));
  }
  /// The mean of both, of the second with this weight. [-]
  [[nodiscard]] static constexpr ActiveShares<T> between(ActiveShares<T> a, ActiveShares<T> b,
                                                         T weight) noexcept {
    return {a.one + weight * (b.one - a.one), a.two + weight * (b.two - a.two)};
  }

  [[nodiscard]] static SpaceVector<T> mean_of(ActiveShares<T> s, const LegOrder<T>& o, T u_dc) noexcept {
    std::array<T, 3> legs{};
    legs[o.legs[0]] = s.one + s.two;
    legs[o.legs[1]] = s.two;
    return u_dc * clarke(ThreePhase<T>{legs[0], legs[1], legs[2]});
  }

  Overmodulation overmodulation_;
};

}  // namespace sextant
