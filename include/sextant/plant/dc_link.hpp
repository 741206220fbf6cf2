#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/appended_system.hpp"
#include "sextant/plant/dc_link_parameters.hpp"

namespace sextant {

/// A DC link whose voltage is a state, appended to the plant, on which it acts by that voltage:
///   C du/dt = i − i_dc − p/u − b u/R_b
///   L di/dt = u_0 − u − R i,   without L: i = (u_0 − u)/R
/// u_0 is the link voltage of the plant's inputs, i the current from the source and i_dc that into the
/// inverter, which follows from the ties of the legs and the phase currents (`Inverter::dc_link_current`),
/// dead time and diodes included; p is what the inverter loses beside (`PlantInputs::inverter_loss`). b is 1
/// from where u has risen to the chopper's upper voltage until it has fallen to the lower one. A source with
/// a diode carries no negative current: it blocks where i falls to zero, and conducts again where u falls to
/// u_0. With a pre-charge resistor R is R + R_p, and L is none, which it makes negligible, until u reaches
/// the contactor's share of u_0: from then on, however far u falls, R and L count, with i from zero on.
///
/// The energies that it meters balance with that into the inverter, `EnergyMeter::dc_link`:
///   E_source = E_resistance + E_chopper + E_dc + ∫p dt + W(t) − W(0),   W = ½ C u² + ½ L i²
///
/// Below a tenth of the nominal u_0 the current of p falls with u, in place of p/u, which has no bound: less
/// is drawn there than is lost.
///
/// Below zero volts the diodes of the bridge would short the link, which is not modelled: the state is not
/// valid there.
template <class T = double>
class DcLink {
 public:
  using Parameters = DcLinkParameters<T>;
  static constexpr int size = 5;
  static constexpr bool feeds_back = true;
  static constexpr int event_count = 3;
  enum Index : std::size_t {
    voltage = 0,         ///< u [V]
    source_current = 1,  ///< i, where the source has an inductance; else zero [A]
    source = 2,          ///< delivered by u_0 [J]
    resistance = 3,      ///< lost in the resistances of source and pre-charge [J]
    chopper = 4          ///< lost in the brake chopper [J]
  };
  /// A source with a diode blocks once its current has reversed by this much. [A]
  static constexpr T current_tolerance = T(1e-4);
  /// It conducts again once the link has fallen this much below it. [V]
  static constexpr T voltage_tolerance = T(1e-3);

  /// The same of a source of that initial voltage.
  constexpr DcLink(const Parameters& parameters, T transient_inductance, T initial_voltage) noexcept
      : DcLink{parameters, transient_inductance, initial_voltage, initial_voltage} {}

  /// The parameters must be valid, and act. transient_inductance: σL_s of the machine [H]; initial_voltage:
  /// to which the capacitor is charged at first [V]; nominal_voltage: of the source [V].
  constexpr DcLink(const Parameters& parameters, T transient_inductance, T initial_voltage,
                   T nominal_voltage) noexcept
      : has_inductance_{parameters.source_inductance > T(0)},
        has_diode_{parameters.source_diode},
        has_precharge_{parameters.has_precharge()},
        is_closed_{!parameters.has_precharge()},
        capacitance_{parameters.capacitance},
        resistance_{parameters.source_resistance},
        precharge_{parameters.source_resistance + parameters.precharge_resistance},
        contactor_share_{parameters.contactor_share},
        inductance_{parameters.source_inductance},
        chopper_conductance_{parameters.has_chopper() ? T(1) / parameters.chopper_resistance : T(0)},
        chopper_on_{parameters.chopper_on},
        chopper_off_{parameters.chopper_off},
        initial_voltage_{initial_voltage},
        least_squared_{T(0.01) * nominal_voltage * nominal_voltage},
        rate_squared_{std::max(
            rate_squared(parameters, resistance_, inductance_, transient_inductance),
            has_precharge_ ? rate_squared(parameters, precharge_, T(0), transient_inductance) : T(0))} {}

  using Values = std::span<const T, std::size_t(size)>;
  using States = std::span<T, std::size_t(size)>;

  /// The equations above.
  constexpr void derivative(const PlantQuantities<T>& plant, Values y,
                            States dy) const noexcept SEXTANT_NONBLOCKING {
    const T u = y[voltage];
    const T i = current(y, plant.u_given);
    const T i_b = chops_ ? chopper_conductance_ * u : T(0);
    const T i_l =
        plant.inverter_loss == T(0) ? T(0) : plant.inverter_loss * u / std::max(u * u, least_squared_);
    const T r = series_resistance();
    dy[voltage] = (i - plant.i_dc - i_l - i_b) / capacitance_;
    dy[source_current] = is_inductive() && conducts_ ? (plant.u_given - u - r * i) / inductance_ : T(0);
    dy[source] = plant.u_given * i;
    dy[resistance] = r * i * i;
    dy[chopper] = u * i_b;
  }

  constexpr void begin(States y, T) const noexcept SEXTANT_NONBLOCKING { y[voltage] = initial_voltage_; }
  constexpr void act(Values y, T, PlantInputs<T>& inputs) const noexcept SEXTANT_NONBLOCKING {
    inputs.u_dc = y[voltage];
  }

  /// Chopper, diode and contactor: distance to the voltage at which it turns, forward current, or reverse
  /// voltage, distance to the voltage at which it closes; 1 of what is not there. [V], [A]
  constexpr void events(Values y, T, const PlantInputs<T>& given,
                        std::span<T, std::size_t(event_count)> g) const noexcept SEXTANT_NONBLOCKING {
    g[0] = g[1] = g[2] = T(1);
    if (has_chopper()) g[0] = chops_ ? y[voltage] - chopper_off_ : chopper_on_ - y[voltage];
    if (!is_closed_ && given.contactor != Contactor::held_open && given.u_dc > T(0))
      g[2] = contactor_share_ * given.u_dc - y[voltage];
    if (!has_diode_) return;
    g[1] =
        conducts_ ? current(y, given.u_dc) + current_tolerance : y[voltage] - given.u_dc + voltage_tolerance;
  }
  constexpr void on_event(int event, States y) noexcept SEXTANT_NONBLOCKING {
    if (event == 0) {
      chops_ = !chops_;
      return;
    }
    if (event == 2) {
      is_closed_ = true;
      return;
    }
    conducts_ = !conducts_;
    if (!conducts_) y[source_current] = T(0);
  }
  constexpr bool settle(States y, T omega_m, const PlantInputs<T>& given) noexcept SEXTANT_NONBLOCKING {
    const bool was_closed = is_closed_;
    if (has_precharge_ && given.contactor == Contactor::welded) is_closed_ = true;
    if (has_precharge_ && given.contactor == Contactor::held_open) open(y);
    std::array<T, std::size_t(event_count)> g;
    events(y, omega_m, given, g);
    for (std::size_t k = 0; k < g.size(); ++k) {
      if (g[k] < T(0)) on_event(int(k), y);
    }
    return g[0] < T(0) || g[1] < T(0) || is_closed_ != was_closed;
  }

  [[nodiscard]] constexpr T rate_squared() const noexcept SEXTANT_NONBLOCKING { return rate_squared_; }
  [[nodiscard]] constexpr bool is_valid(Values y) const noexcept SEXTANT_NONBLOCKING {
    return y[voltage] >= T(0);
  }

  /// Current from a source of the voltage u_0 [V]. [A]
  [[nodiscard]] constexpr T current(Values y, T u_0) const noexcept SEXTANT_NONBLOCKING {
    if (!conducts_) return T(0);
    return is_inductive() ? y[source_current] : (u_0 - y[voltage]) / series_resistance();
  }
  /// W: in capacitor and inductance. [J]
  [[nodiscard]] constexpr T stored(Values y) const noexcept SEXTANT_NONBLOCKING {
    return T(0.5) *
           (capacitance_ * y[voltage] * y[voltage] + inductance_ * y[source_current] * y[source_current]);
  }
  /// True while the chopper is on.
  [[nodiscard]] constexpr bool chops() const noexcept SEXTANT_NONBLOCKING { return chops_; }
  /// False while the source's diode blocks.
  [[nodiscard]] constexpr bool conducts() const noexcept SEXTANT_NONBLOCKING { return conducts_; }
  /// True while the main contactor is closed, and where there is none.
  [[nodiscard]] constexpr bool is_closed() const noexcept SEXTANT_NONBLOCKING { return is_closed_; }

 private:
  [[nodiscard]] constexpr bool has_chopper() const noexcept SEXTANT_NONBLOCKING {
    return chopper_conductance_ > T(0);
  }
  /// The capacitor discharges by (1/R + 1/R_b)/C, or oscillates with L by R/L and 1/√(LC); against the
  /// machine, i_dc = |ŝ · i_s| and σL_s di_s/dt = 2/3 u ŝ with a unit vector ŝ, by √(2/(3 σL_s C)). [1/s²]
  /// series, inductance: between source and capacitor [Ω], [H]
  static constexpr T rate_squared(const Parameters& p, T series, T inductance,
                                  T transient_inductance) noexcept {
    const T c = p.capacitance;
    const bool has_inductance = inductance > T(0);
    T decay = has_inductance ? series / inductance : T(1) / (series * c);
    if (p.has_chopper()) decay += T(1) / (p.chopper_resistance * c);
    const T oscillation = has_inductance ? T(1) / (inductance * c) : T(0);
    return decay * decay + oscillation + T(2) / (T(3) * transient_inductance * c);
  }

  /// What the inductance stores goes into the resistor. [J]
  constexpr void open(States y) noexcept SEXTANT_NONBLOCKING {
    is_closed_ = false;
    y[resistance] += T(0.5) * inductance_ * y[source_current] * y[source_current];
    y[source_current] = T(0);
  }
  [[nodiscard]] constexpr bool is_inductive() const noexcept SEXTANT_NONBLOCKING {
    return has_inductance_ && is_closed_;
  }
  /// In series with the source. [Ω]
  [[nodiscard]] constexpr T series_resistance() const noexcept SEXTANT_NONBLOCKING {
    return is_closed_ ? resistance_ : precharge_;
  }

  bool has_inductance_;
  bool has_diode_;
  bool has_precharge_;
  bool is_closed_;  ///< the main contactor
  bool chops_{false};
  bool conducts_{true};
  T capacitance_;          ///< C [F]
  T resistance_;           ///< R [Ω]
  T precharge_;            ///< R + R_p [Ω]
  T contactor_share_;      ///< of u_0, at which the contactor closes [-]
  T inductance_;           ///< L [H]
  T chopper_conductance_;  ///< 1/R_b; 0: no chopper [S]
  T chopper_on_;           ///< [V]
  T chopper_off_;          ///< [V]
  T initial_voltage_;      ///< [V]
  T least_squared_;        ///< a tenth of the nominal u_0, squared [V²]
  T rate_squared_;         ///< [1/s²]
};

}  // namespace sextant
