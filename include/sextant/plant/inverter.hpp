#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"
#include "sextant/core/two_level_inverter.hpp"
#include "sextant/plant/back_emf.hpp"
#include "sextant/plant/conduction_drops.hpp"
#include "sextant/plant/leg_tie.hpp"
#include "sextant/plant/stator_voltage_map.hpp"

namespace sextant {

/// Two-level inverter on a DC link: switches and freewheeling diodes that are ideal or, while they
/// conduct, take a threshold voltage V_t. A dead time is a time for which a leg is off.
///
/// A leg is low, high or off. An off leg carries its phase current through a diode: the lower one while
/// i_x > 0, the upper one while i_x < 0. So each leg has a lowest potential, at which it carries positive
/// current, and a highest one, for negative current:
///   off:  −V_t and u_dc + V_t,    low:  ∓V_t,    high:  u_dc ∓ V_t
/// Once its current is zero the leg floats, until its potential leaves the range between them and current
/// flows again. A driven leg without threshold has no such range, is tied for good and carries either
/// current. Current i_x is positive into the machine. The machine enters by its current i_s and its `BackEmf`
/// e (stationary frame, amplitude-invariant).
///
/// The slope resistance of `ConductionDrops` is not in here: as each current that flows passes one device, it
/// is a part of the stator resistance of the machine.
///
/// The cable of one phase can be opened: its contact carries the current until the current crosses zero, and
/// from then on the phase floats without diodes, whatever its leg does.
///
/// By `set_mean` the legs have the mean of what they do over a time in the place of states: potentials
/// d_x u_dc − V_t sign(i_x), d_x their duties and i_x the currents at its beginning. There are no events
/// then, and an open cable counts as whole.
template <class T = double>
class Inverter {
 public:
  static constexpr int event_count = 3;  ///< one event a leg
  static constexpr int no_phase = -1;    ///< of `open_phase`: every cable is whole
  /// A diode blocks once its current has reversed by this much. [A]
  static constexpr T current_tolerance = T(1e-4);
  /// A diode conducts once its forward voltage has reached this much above its threshold. [V]
  static constexpr T voltage_tolerance = T(1e-3);

  /// threshold_voltage: V_t [V]
  constexpr explicit Inverter(T threshold_voltage = T(0)) noexcept SEXTANT_NONBLOCKING
      : threshold_{threshold_voltage},
        is_plain_{threshold_voltage == T(0)} {}

  /// Opens the cable of phase 0, 1 or 2 at the current i_s, or makes all cables whole (`no_phase`); to be
  /// followed by `set`.
  constexpr void open_phase(int phase, SpaceVector<T> i_s) noexcept SEXTANT_NONBLOCKING {
    open_ = phase;
    is_plain_ = phase == no_phase && threshold_ == T(0);
    arc_ = T(0);
    if (phase == no_phase) return;
    const T i = phases_of(i_s)[static_cast<std::size_t>(phase)];
    arc_ = i < T(0) ? T(-1) : T(1);
  }
  /// The phase whose cable has been opened, or `no_phase`.
  [[nodiscard]] constexpr int open_phase() const noexcept SEXTANT_NONBLOCKING { return open_; }

  /// True when legs that are all driven are tied by their states alone: no cable is open and no current has
  /// to overcome a threshold.
  [[nodiscard]] constexpr bool is_plain() const noexcept SEXTANT_NONBLOCKING { return is_plain_; }

  /// Sets leg states that are all driven, and the DC-link voltage [V], of an inverter that is plain.
  constexpr void set_driven(SwitchState state, T u_dc) noexcept SEXTANT_NONBLOCKING {
    state_ = state;
    u_dc_ = u_dc;
    is_mean_ = false;
    ties_ = {driven_tie(state.a()), driven_tie(state.b()), driven_tie(state.c())};
    forward_ = {};
    floating_ = 0;
    without_current_ = 0;
    map_ = {T(0), T(0), T(0), sextant::stator_voltage(state, u_dc)};
  }

  /// Sets any leg states and the DC-link voltage [V] and finds the ties of the legs.
  constexpr void set(SwitchState state, T u_dc, SpaceVector<T> i_s,
                     const BackEmf<T>& e) noexcept SEXTANT_NONBLOCKING {
    if (is_plain_ && is_driven(state)) return set_driven(state, u_dc);
    state_ = state;
    u_dc_ = u_dc;
    is_mean_ = false;
    find_ranges();
    tie_by_currents(phases_of(i_s));
    settle(e);
  }

  /// Sets the mean of the legs, by their duties d_x [-] and the current i_s [A] at the beginning. state: of
  /// the legs at the end, all driven.
  constexpr void set_mean(const ThreePhase<T>& duties, SwitchState state, T u_dc,
                          SpaceVector<T> i_s) noexcept SEXTANT_NONBLOCKING {
    set_driven(state, u_dc);
    is_mean_ = true;
    duties_ = {duties.a, duties.b, duties.c};
    std::array<T, 3> lost = phases_of(i_s);
    for (T& i : lost) i = i > T(0) ? threshold_ : i < T(0) ? -threshold_ : T(0);
    unit_mean_ = clarke(duties);
    lost_ = clarke(ThreePhase<T>{lost[0], lost[1], lost[2]});
    map_.offset = mean_voltage(u_dc);
  }

  /// Sets the DC-link voltage [V] under the ties that there are: the link has moved, and no event has come.
  constexpr void set_link_voltage(T u_dc) noexcept SEXTANT_NONBLOCKING {
    u_dc_ = u_dc;
    if (is_mean_) {
      map_.offset = mean_voltage(u_dc);
      return;
    }
    if (is_plain_ && is_driven(state_)) {
      map_.offset = sextant::stator_voltage(state_, u_dc);
      return;
    }
    find_ranges();
    map_ = stator_voltage_map(ties_, std::array<T, 3>{potential(0), potential(1), potential(2)});
  }

  /// The event of a leg has come: a conducting device blocks, an arc ends, or a device of a floating leg
  /// takes over.
  constexpr void on_event(int leg, SpaceVector<T> i_s, const BackEmf<T>& e) noexcept SEXTANT_NONBLOCKING {
    const auto x = static_cast<std::size_t>(leg);
    const bool was_floating = ties_[x] == LegTie::floating;
    const T v = was_floating && floating_ < 3 ? leg_potentials(e)[x] : T(0);
    const bool none_tied = floating_ == 3;
    std::array<T, 3> i = phases_of(i_s);
    if (!was_floating) i[x] = T(0);
    tie_by_currents(i);
    if (none_tied) {
      tie_outermost(phases_of(e.e));
    } else if (was_floating) {
      tie_beyond(x, v);
    }
    settle(e);
  }

  /// The value of each leg's event function; the event is its fall through zero. A conducting device or an
  /// arc: its forward current [A]. A floating leg: how far its potential is inside its range [V].
  /// Otherwise 1.
  [[nodiscard]] constexpr std::array<T, 3> events(SpaceVector<T> i_s,
                                                  const BackEmf<T>& e) const noexcept SEXTANT_NONBLOCKING {
    return with_currents(margins(e), i_s);
  }

  /// The same while no leg floats (`voltage_is_fixed`): no back-EMF has a say.
  [[nodiscard]] constexpr std::array<T, 3> current_events(SpaceVector<T> i_s) const noexcept
      SEXTANT_NONBLOCKING {
    return with_currents({T(1), T(1), T(1)}, i_s);
  }

  /// i_s with the currents of the legs that had none when their ties were found made exactly zero: those that
  /// float, and those whose potential would have left its range at once. What a tolerance has left of such a
  /// current may have the sign that its device does not let pass. [A]
  [[nodiscard]] constexpr SpaceVector<T> admissible_current(SpaceVector<T> i_s) const noexcept
      SEXTANT_NONBLOCKING {
    if (!has_idle_legs()) return i_s;
    if (without_current_ > 1) return {};
    const SpaceVector<T> d = phase_axes<T>[idle_leg_];
    const SpaceVector<T> along{d.alpha * d.alpha * i_s.alpha + d.alpha * d.beta * i_s.beta,
                               d.alpha * d.beta * i_s.alpha + d.beta * d.beta * i_s.beta};
    return i_s - along;
  }

  /// Leg potentials against the negative rail. Without any tied leg they are undefined and reported as their
  /// deviation from the star point. [V]
  [[nodiscard]] constexpr std::array<T, 3> leg_potentials(const BackEmf<T>& e) const noexcept
      SEXTANT_NONBLOCKING {
    const std::array<T, 3> u = phases_of(map_(e));
    T star_point{};
    for (std::size_t x = 0; x < 3; ++x) {
      if (ties_[x] != LegTie::floating) star_point = potential(x) - u[x];
    }
    return {u[0] + star_point, u[1] + star_point, u[2] + star_point};
  }

  /// Current drawn from the DC link through switches and diodes; negative when it flows back. [A]
  [[nodiscard]] constexpr T dc_link_current(SpaceVector<T> i_s) const noexcept SEXTANT_NONBLOCKING {
    const std::array<T, 3> i = phases_of(i_s);
    T sum{};
    if (is_mean_) [[unlikely]] {
      for (std::size_t x = 0; x < 3; ++x) sum += duties_[x] * i[x];
      return sum;
    }
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
  /// That voltage, with another DC-link voltage [V] under the same ties. [V]
  [[nodiscard]] constexpr SpaceVector<T> fixed_voltage(T u_dc) const noexcept SEXTANT_NONBLOCKING {
    if (is_mean_) return mean_voltage(u_dc);
    if (is_plain_ && is_driven(state_)) return sextant::stator_voltage(state_, u_dc);
    std::array<T, 3> v;
    for (std::size_t x = 0; x < 3; ++x) v[x] = tied_potential(ties_[x], u_dc) - threshold_ * forward_[x];
    return clarke(ThreePhase<T>{v[0], v[1], v[2]});
  }
  /// True when a leg had no current when the ties were found.
  [[nodiscard]] constexpr bool has_idle_legs() const noexcept SEXTANT_NONBLOCKING {
    return without_current_ > 0;
  }
  /// True when a leg is off, a cable open or a threshold to be overcome, so that events can come or the
  /// voltage depends on the EMF.
  [[nodiscard]] constexpr bool has_events() const noexcept SEXTANT_NONBLOCKING {
    return !is_plain_ || !is_driven(state_);
  }

 private:
  /// Of the mean of the legs. [V]
  [[nodiscard]] constexpr SpaceVector<T> mean_voltage(T u_dc) const noexcept SEXTANT_NONBLOCKING {
    return u_dc * unit_mean_ - lost_;
  }

  /// Event functions with those of the legs that carry a current in their place.
  [[nodiscard]] constexpr std::array<T, 3> with_currents(
      std::array<T, 3> g, SpaceVector<T> i_s) const noexcept SEXTANT_NONBLOCKING {
    if (is_mean_) return g;
    const std::array<T, 3> i = phases_of(i_s);
    for (std::size_t x = 0; x < 3; ++x) {
      if (has_arc(x)) g[x] = arc_ * i[x] + current_tolerance;
      if (forward_[x] != T(0)) g[x] = forward_[x] * i[x] + current_tolerance;
    }
    return g;
  }

  // Twice the tolerance: when two diodes block together, both must be seen as blocking.
  static constexpr T zero_current = T(2) * current_tolerance;

  [[nodiscard]] constexpr bool is_open(std::size_t x) const noexcept SEXTANT_NONBLOCKING {
    return open_ == int(x) && arc_ == T(0);
  }
  [[nodiscard]] constexpr bool has_arc(std::size_t x) const noexcept SEXTANT_NONBLOCKING {
    return open_ == int(x) && arc_ != T(0);
  }
  /// The tie of a leg without current.
  [[nodiscard]] constexpr LegTie blocked_tie(std::size_t x) const noexcept SEXTANT_NONBLOCKING {
    return is_open(x) || threshold_ > T(0) ? LegTie::floating : driven_tie(leg_states(state_)[x]);
  }

  /// Potential of a tied leg. [V]
  [[nodiscard]] constexpr T potential(std::size_t x) const noexcept SEXTANT_NONBLOCKING {
    return tied_potential(ties_[x], u_dc_) - threshold_ * forward_[x];
  }
  constexpr void find_ranges() noexcept SEXTANT_NONBLOCKING {
    const std::array<LegState, 3> states = leg_states(state_);
    for (std::size_t x = 0; x < 3; ++x) {
      lowest_[x] = (states[x] == LegState::high ? u_dc_ : T(0)) - threshold_;
      highest_[x] = (states[x] == LegState::low ? T(0) : u_dc_) + threshold_;
    }
  }

  /// A leg conducts positive current (1) or negative one (−1).
  constexpr void conduct(std::size_t x, T sign) noexcept SEXTANT_NONBLOCKING {
    const LegState state = leg_states(state_)[x];
    const bool by_upper = state == LegState::off ? sign < T(0) : state == LegState::high;
    ties_[x] = by_upper ? LegTie::high : LegTie::low;
    forward_[x] = sign;
  }
  /// A leg conducts because its potential without current, v, lies beyond its range.
  constexpr void tie_beyond(std::size_t x, T v) noexcept SEXTANT_NONBLOCKING {
    conduct(x, v > (lowest_[x] + highest_[x]) / T(2) ? T(-1) : T(1));
  }
  constexpr void block(std::size_t x) noexcept SEXTANT_NONBLOCKING {
    ties_[x] = blocked_tie(x);
    forward_[x] = T(0);
  }

  /// A driven leg that carries either current.
  [[nodiscard]] constexpr bool is_tied_for_good(std::size_t x) const noexcept SEXTANT_NONBLOCKING {
    return threshold_ == T(0) && leg_states(state_)[x] != LegState::off;
  }

  /// Ties by the phase currents, and the end of an arc whose current is zero.
  constexpr void tie_by_currents(const std::array<T, 3>& i) noexcept SEXTANT_NONBLOCKING {
    if (open_ != no_phase && !(arc_ * i[static_cast<std::size_t>(open_)] > zero_current)) arc_ = T(0);
    for (std::size_t x = 0; x < 3; ++x) {
      block(x);
      if (is_tied_for_good(x)) continue;
      if (i[x] > zero_current) conduct(x, T(1));
      if (i[x] < -zero_current) conduct(x, T(-1));
    }
    // Currents add up to zero, so with two of them zero no device conducts.
    if (floating_legs(ties_) >= 2) {
      for (std::size_t x = 0; x < 3; ++x) block(x);
    }
    without_current_ = floating_legs(ties_);
    for (std::size_t x = 0; x < 3; ++x) {
      if (ties_[x] == LegTie::floating) idle_leg_ = x;
    }
  }

  /// Ties floating legs that would leave their ranges, the worst first, until none is left.
  constexpr void settle(const BackEmf<T>& e) noexcept SEXTANT_NONBLOCKING {
    for (int round = 0; round <= 3; ++round) {
      floating_ = floating_legs(ties_);
      map_ = stator_voltage_map(ties_, std::array<T, 3>{potential(0), potential(1), potential(2)});
      const std::array<T, 3> g = margins(e);
      const auto worst = static_cast<std::size_t>(std::min_element(g.begin(), g.end()) - g.begin());
      if (!(g[worst] < T(0))) return;
      if (floating_ == 3) {
        tie_outermost(phases_of(e.e));
      } else {
        tie_beyond(worst, leg_potentials(e)[worst]);
      }
    }
  }

  /// Distance of each floating leg to the potential at which it conducts; 1 for tied legs and for an open
  /// phase. With all three floating the line-to-line EMF counts, with leg a for all. [V]
  [[nodiscard]] constexpr std::array<T, 3> margins(const BackEmf<T>& e) const noexcept SEXTANT_NONBLOCKING {
    std::array<T, 3> g{T(1), T(1), T(1)};
    if (floating_ == 0) return g;
    const std::array<T, 3> v = leg_potentials(e);
    if (floating_ == 3) {
      const Outermost outer = outermost(v);
      g[0] = (highest_[outer.high] - lowest_[outer.low]) - (v[outer.high] - v[outer.low]) + voltage_tolerance;
      return g;
    }
    for (std::size_t x = 0; x < 3; ++x) {
      if (ties_[x] == LegTie::floating && !is_open(x))
        g[x] = std::min(v[x] - lowest_[x], highest_[x] - v[x]) + voltage_tolerance;
    }
    return g;
  }

  struct Outermost {
    std::size_t high;
    std::size_t low;
  };
  /// The legs that are nearest to or furthest beyond the upper and the lower end of their ranges, where all
  /// float; without an open phase.
  [[nodiscard]] constexpr Outermost outermost(const std::array<T, 3>& v) const noexcept SEXTANT_NONBLOCKING {
    const std::size_t first = is_open(0) ? 1 : 0;
    Outermost outer{first, first};
    for (std::size_t x = first + 1; x < 3; ++x) {
      if (is_open(x)) continue;
      if (v[x] - v[outer.high] > highest_[x] - highest_[outer.high]) outer.high = x;
      if (v[x] - v[outer.low] < lowest_[x] - lowest_[outer.low]) outer.low = x;
    }
    return outer;
  }

  constexpr void tie_outermost(const std::array<T, 3>& e) noexcept SEXTANT_NONBLOCKING {
    const Outermost outer = outermost(e);
    conduct(outer.high, T(-1));
    conduct(outer.low, T(1));
  }

  T threshold_;    ///< V_t [V]
  bool is_plain_;  ///< no threshold, no open cable
  SwitchState state_{};
  T u_dc_{};  ///< [V]
  LegTies ties_{LegTie::floating, LegTie::floating, LegTie::floating};
  std::array<T, 3> lowest_{};   ///< potentials at which the legs carry positive current [V]
  std::array<T, 3> highest_{};  ///< the same of negative current [V]
  std::array<T, 3> forward_{};  ///< sign of the current that the leg's device lets pass; 0: floats, or either
  int floating_{3};             ///< legs that float
  int without_current_{3};      ///< legs that had no current when the ties were found
  std::size_t idle_leg_{0};     ///< one of them
  int open_{no_phase};          ///< phase whose cable is open
  T arc_{};                     ///< sign of the current that its contact still carries; 0: none [-]
  bool is_mean_{false};         ///< duties in the place of states
  std::array<T, 3> duties_{};   ///< d_x [-]
  SpaceVector<T> unit_mean_{};  ///< their space vector [-]
  SpaceVector<T> lost_{};       ///< what thresholds take of the mean [V]
  StatorVoltageMap<T> map_{T(1), T(0), T(1), {}};
};

}  // namespace sextant
