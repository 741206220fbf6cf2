#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"
#include "sextant/core/two_level_inverter.hpp"
#include "sextant/plant/leg_tie.hpp"
#include "sextant/plant/stator_voltage_map.hpp"

namespace sextant {

/// Two-level inverter on a stiff DC link: ideal switches, ideal freewheeling diodes, no dead time.
///
/// A leg is low, high or off. An off leg carries its phase current through a diode: the lower one while
/// i_x > 0, the upper one while i_x < 0. Once its current is zero it floats, until its potential leaves
/// [0, u_dc] and a diode takes it over again. Current i_x is positive into the machine. The machine enters by
/// its current i_s and its back-EMF e (stationary frame, amplitude-invariant).
template <class T = double>
class Inverter {
 public:
  static constexpr int event_count = 3;  ///< one event a leg
  /// A diode blocks once its current has reversed by this much. [A]
  static constexpr T current_tolerance = T(1e-4);
  /// A diode conducts once its forward voltage has reached this much. [V]
  static constexpr T voltage_tolerance = T(1e-3);

  /// Sets leg states that are all driven, and the DC-link voltage [V].
  constexpr void set_driven(SwitchState state, T u_dc) noexcept SEXTANT_NONBLOCKING {
    state_ = state;
    u_dc_ = u_dc;
    ties_ = {driven_tie(state.a()), driven_tie(state.b()), driven_tie(state.c())};
    floating_ = 0;
    map_ = {T(0), T(0), T(0), sextant::stator_voltage(state, u_dc)};
  }

  /// Sets any leg states and the DC-link voltage [V] and finds the ties of the off legs.
  constexpr void set(SwitchState state, T u_dc, SpaceVector<T> i_s,
                     SpaceVector<T> e) noexcept SEXTANT_NONBLOCKING {
    if (is_driven(state)) return set_driven(state, u_dc);
    state_ = state;
    u_dc_ = u_dc;
    ties_ = ties_from_currents(phases_of(i_s));
    settle(e);
  }

  /// The event of a leg has come: a conducting diode blocks, or a floating leg's diode takes over.
  constexpr void on_event(int leg, SpaceVector<T> i_s, SpaceVector<T> e) noexcept SEXTANT_NONBLOCKING {
    const auto x = static_cast<std::size_t>(leg);
    const bool was_floating = ties_[x] == LegTie::floating;
    const T v = was_floating && floating_ < 3 ? leg_potentials(e)[x] : T(0);
    const bool none_tied = floating_ == 3;
    std::array<T, 3> i = phases_of(i_s);
    if (!was_floating) i[x] = T(0);
    ties_ = ties_from_currents(i);
    if (none_tied) {
      tie_outermost(phases_of(e));
    } else if (was_floating) {
      ties_[x] = v > u_dc_ / T(2) ? LegTie::high : LegTie::low;
    }
    settle(e);
  }

  /// The value of each leg's event function; the event is its fall through zero. A conducting diode: its
  /// forward current [A]. A floating leg: how far its potential is inside [0, u_dc] [V]. Otherwise 1.
  [[nodiscard]] constexpr std::array<T, 3> events(SpaceVector<T> i_s,
                                                  SpaceVector<T> e) const noexcept SEXTANT_NONBLOCKING {
    const std::array<LegState, 3> states = leg_states(state_);
    const std::array<T, 3> i = phases_of(i_s);
    std::array<T, 3> g = margins(e);
    for (std::size_t x = 0; x < 3; ++x) {
      if (states[x] != LegState::off || ties_[x] == LegTie::floating) continue;
      g[x] = (ties_[x] == LegTie::low ? i[x] : -i[x]) + current_tolerance;
    }
    return g;
  }

  /// i_s with the currents of floating legs made exactly zero. [A]
  [[nodiscard]] constexpr SpaceVector<T> admissible_current(SpaceVector<T> i_s) const noexcept
      SEXTANT_NONBLOCKING {
    return floating_ == 0 ? i_s : i_s - map_.gain(i_s);
  }

  /// Leg potentials against the negative rail. Without any tied leg they are undefined and reported as their
  /// deviation from the star point. [V]
  [[nodiscard]] constexpr std::array<T, 3> leg_potentials(SpaceVector<T> e) const noexcept
      SEXTANT_NONBLOCKING {
    const std::array<T, 3> u = phases_of(map_(e));
    T star_point{};
    for (std::size_t x = 0; x < 3; ++x) {
      if (ties_[x] != LegTie::floating) star_point = tied_potential(ties_[x], u_dc_) - u[x];
    }
    return {u[0] + star_point, u[1] + star_point, u[2] + star_point};
  }

  /// Current drawn from the DC link through switches and diodes; negative when it flows back. [A]
  [[nodiscard]] constexpr T dc_link_current(SpaceVector<T> i_s) const noexcept SEXTANT_NONBLOCKING {
    const std::array<T, 3> i = phases_of(i_s);
    T sum{};
    for (std::size_t x = 0; x < 3; ++x) sum += ties_[x] == LegTie::high ? i[x] : T(0);
    return sum;
  }

  [[nodiscard]] constexpr SwitchState state() const noexcept SEXTANT_NONBLOCKING { return state_; }
  [[nodiscard]] constexpr T u_dc() const noexcept SEXTANT_NONBLOCKING { return u_dc_; }
  [[nodiscard]] constexpr const LegTies& ties() const noexcept SEXTANT_NONBLOCKING { return ties_; }
  [[nodiscard]] constexpr const StatorVoltageMap<T>& voltage_map() const noexcept SEXTANT_NONBLOCKING {
    return map_;
  }
  /// True when no leg floats: the stator voltage is constant, `voltage_map().offset`.
  [[nodiscard]] constexpr bool voltage_is_fixed() const noexcept SEXTANT_NONBLOCKING {
    return floating_ == 0;
  }
  /// True when a leg is off, so that events can come.
  [[nodiscard]] constexpr bool has_events() const noexcept SEXTANT_NONBLOCKING { return !is_driven(state_); }

 private:
  [[nodiscard]] constexpr LegTies ties_from_currents(const std::array<T, 3>& i) const noexcept
      SEXTANT_NONBLOCKING {
    const std::array<LegState, 3> states = leg_states(state_);
    // Twice the tolerance: when two diodes block together, both must be seen as blocking.
    constexpr T zero = T(2) * current_tolerance;
    LegTies ties{};
    for (std::size_t x = 0; x < 3; ++x) {
      ties[x] = driven_tie(states[x]);
      if (states[x] != LegState::off) continue;
      if (i[x] > zero) ties[x] = LegTie::low;
      if (i[x] < -zero) ties[x] = LegTie::high;
    }
    // Currents add up to zero, so with two of them zero no diode conducts.
    if (floating_legs(ties) >= 2) {
      for (std::size_t x = 0; x < 3; ++x) ties[x] = driven_tie(states[x]);
    }
    return ties;
  }

  /// Ties floating legs that would leave [0, u_dc], the worst first, until none is left.
  constexpr void settle(SpaceVector<T> e) noexcept SEXTANT_NONBLOCKING {
    for (int round = 0; round <= 3; ++round) {
      floating_ = floating_legs(ties_);
      map_ = stator_voltage_map(ties_, u_dc_);
      const std::array<T, 3> g = margins(e);
      const auto worst = static_cast<std::size_t>(std::min_element(g.begin(), g.end()) - g.begin());
      if (!(g[worst] < T(0))) return;
      if (floating_ == 3) {
        tie_outermost(phases_of(e));
      } else {
        ties_[worst] = leg_potentials(e)[worst] > u_dc_ / T(2) ? LegTie::high : LegTie::low;
      }
    }
  }

  /// Distance of each floating leg to the potential at which a diode conducts; 1 for tied legs. With all
  /// three floating the line-to-line EMF counts, with leg a for all. [V]
  [[nodiscard]] constexpr std::array<T, 3> margins(SpaceVector<T> e) const noexcept SEXTANT_NONBLOCKING {
    std::array<T, 3> g{T(1), T(1), T(1)};
    if (floating_ == 0) return g;
    const std::array<T, 3> v = leg_potentials(e);
    if (floating_ == 3) {
      g[0] = u_dc_ - (std::max({v[0], v[1], v[2]}) - std::min({v[0], v[1], v[2]})) + voltage_tolerance;
      return g;
    }
    for (std::size_t x = 0; x < 3; ++x) {
      if (ties_[x] == LegTie::floating) g[x] = std::min(v[x], u_dc_ - v[x]) + voltage_tolerance;
    }
    return g;
  }

  constexpr void tie_outermost(const std::array<T, 3>& e) noexcept SEXTANT_NONBLOCKING {
    ties_[static_cast<std::size_t>(std::max_element(e.begin(), e.end()) - e.begin())] = LegTie::high;
    ties_[static_cast<std::size_t>(std::min_element(e.begin(), e.end()) - e.begin())] = LegTie::low;
  }

  SwitchState state_{};
  T u_dc_{};  ///< [V]
  LegTies ties_{LegTie::floating, LegTie::floating, LegTie::floating};
  int floating_{3};  ///< legs that float
  StatorVoltageMap<T> map_{T(1), T(0), T(1), {}};
};

}  // namespace sextant
