#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/switch_state.hpp"
#include "sextant/plant/conduction_drops.hpp"
#include "sextant/plant/foster_network.hpp"
#include "sextant/plant/inverter_loss_parameters.hpp"
#include "sextant/plant/loss_curve.hpp"

namespace sextant {

/// A device of a leg.
enum class LegDevice : std::uint8_t { upper_switch, upper_diode, lower_switch, lower_diode };
inline constexpr std::size_t leg_devices = 4;
inline constexpr std::size_t inverter_devices = 3 * leg_devices;

/// The device that carries the current of a leg in that state; forward: the current is positive, into the
/// machine. A leg that is off conducts by diodes alone.
[[nodiscard]] constexpr LegDevice conducting_device(LegState state,
                                                    bool forward) noexcept SEXTANT_NONBLOCKING {
  if (forward) return state == LegState::high ? LegDevice::upper_switch : LegDevice::lower_diode;
  return state == LegState::low ? LegDevice::lower_switch : LegDevice::upper_diode;
}

/// Of legs a, b, c, in the order of `LegDevice`.
template <class V>
using PerDevice = std::array<V, inverter_devices>;

/// What the inverter has lost so far, at one instant. [J]
struct InverterEnergies {
  double lost{};   ///< in all switches and diodes
  double drawn{};  ///< from the link, for what is lost beyond the drops of the plant

  friend InverterEnergies operator+(const InverterEnergies& a, const InverterEnergies& b) noexcept {
    return {a.lost + b.lost, a.drawn + b.drawn};
  }
  friend InverterEnergies operator-(const InverterEnergies& a, const InverterEnergies& b) noexcept {
    return {a.lost - b.lost, a.drawn - b.drawn};
  }
};

/// Losses of six switches and six diodes by the curves of a data sheet, and the temperatures of their
/// junctions:
///   conduction  ∫ v(|i|, ϑ) |i| dt of the device that carries the current of a leg, which runs in a line
///               over a gate segment, by Simpson's rule on either side of a zero of it
///   switching   where the current passes from one device of a leg to another: E_off(|i|, ϑ) (u/u_ref)^k of
///               a switch that it leaves, E_on of one that it comes to, E_rr of a diode that a switch
///               relieves
///   ϑ_j = ϑ_case + Z_j, ϑ_case = ϑ_ambient + Z_case: Foster networks, the case's heated by all devices
/// Source: A. Wintrich et al., "Application Manual Power Semiconductors", SEMIKRON, 2nd ed. 2015,
/// chapter 5.2.
///
/// Temperatures move at the end of a reading, by its mean powers; over the next one the curves have them.
///
/// The plant's voltages know nothing of these curves, but of its `ConductionDrops`, whose loss they replace.
/// The rest, which can be below zero, is drawn from the link with constant power over the next reading: so
/// the energy from the link is that which the plant's equations give, and what is `drawn` beside.
class InverterLosses {
 public:
  /// The parameters must be valid; drops: those of the plant.
  InverterLosses(const InverterLossParameters& p, const ConductionDrops<>& drops)
      : drops_{drops},
        switch_voltage_{p.switch_voltage.cold, p.switch_voltage.hot},
        diode_voltage_{p.diode_voltage.cold, p.diode_voltage.hot},
        turn_on_{p.turn_on.cold, p.turn_on.hot},
        turn_off_{p.turn_off.cold, p.turn_off.hot},
        recovery_{p.recovery.cold, p.recovery.hot},
        cold_{p.cold},
        per_kelvin_{1.0 / (p.hot - p.cold)},
        energy_voltage_{p.energy_voltage},
        switch_exponent_{p.switch_exponent},
        diode_exponent_{p.diode_exponent},
        ambient_{p.ambient},
        case_{p.case_network} {
    if (!p.case_network.empty()) case_.begin(p.start_case.value_or(p.ambient) - p.ambient);
    const FosterNetwork of_switch{p.switch_network};
    const FosterNetwork of_diode{p.diode_network};
    for (std::size_t d = 0; d < inverter_devices; ++d) junctions_[d] = is_switch(d) ? of_switch : of_diode;
    update_temperatures();
  }

  /// A reading begins, with that link voltage [V] throughout.
  void begin(double u_dc) noexcept SEXTANT_NONBLOCKING {
    heat_ = {};
    dropped_ = 0.0;
    seconds_ = 0.0;
    const double ratio = std::max(0.0, u_dc) / energy_voltage_;
    switch_scale_ = std::pow(ratio, switch_exponent_);
    diode_scale_ = std::pow(ratio, diode_exponent_);
  }

  /// A gate segment of that length [s], over which the currents [A] run in lines.
  void add_segment(SwitchState state, ThreePhase<> begin, ThreePhase<> end,
                   double seconds) noexcept SEXTANT_NONBLOCKING {
    const std::array<LegState, 3> legs{state.a(), state.b(), state.c()};
    const std::array<double, 3> from{begin.a, begin.b, begin.c};
    const std::array<double, 3> to{end.a, end.b, end.c};
    for (std::size_t x = 0; x < 3; ++x) {
      commutate(x, legs[x], from[x]);
      conduct(x, legs[x], from[x], to[x], seconds);
    }
    seconds_ += seconds;
  }

  /// The reading is over: temperatures move.
  void end() noexcept SEXTANT_NONBLOCKING {
    if (!(seconds_ > 0.0)) return;
    double sum = 0.0;
    for (std::size_t d = 0; d < inverter_devices; ++d) {
      sum += heat_[d];
      junctions_[d].step(heat_[d] / seconds_, seconds_);
    }
    case_.step(sum / seconds_, seconds_);
    update_temperatures();
    energies_.lost += sum;
    energies_.drawn += drawn_power_ * seconds_;
    power_ = sum / seconds_;
    drawn_power_ = (sum - dropped_) / seconds_;
  }

  /// Up to the end of the last reading.
  [[nodiscard]] const InverterEnergies& energies() const noexcept SEXTANT_NONBLOCKING { return energies_; }
  /// Mean of all losses over the last reading. [W]
  [[nodiscard]] double power() const noexcept SEXTANT_NONBLOCKING { return power_; }
  /// Drawn from the link over the next reading, for what is lost beyond the drops. [W]
  [[nodiscard]] double drawn_power() const noexcept SEXTANT_NONBLOCKING { return drawn_power_; }
  /// Lost by each device in the last reading. [J]
  [[nodiscard]] const PerDevice<double>& heat() const noexcept SEXTANT_NONBLOCKING { return heat_; }
  /// Of each junction at the end of the last reading. [°C]
  [[nodiscard]] const PerDevice<double>& junction_temperatures() const noexcept SEXTANT_NONBLOCKING {
    return temperatures_;
  }
  [[nodiscard]] double hottest_junction() const noexcept SEXTANT_NONBLOCKING {
    return *std::max_element(temperatures_.begin(), temperatures_.end());
  }  ///< [°C]
  [[nodiscard]] double case_temperature() const noexcept SEXTANT_NONBLOCKING {
    return ambient_ + case_.rise();
  }  ///< [°C]

 private:
  /// Currents below it have no device: a leg that floats. [A]
  static constexpr double no_current = 1e-3;

  [[nodiscard]] static constexpr bool is_switch(std::size_t device) noexcept SEXTANT_NONBLOCKING {
    return device % 2 == 0;
  }
  [[nodiscard]] static constexpr std::size_t place(std::size_t leg,
                                                   LegDevice d) noexcept SEXTANT_NONBLOCKING {
    return leg_devices * leg + std::size_t(d);
  }
  /// Share of the way from the cold to the hot temperature of the curves. [-]
  [[nodiscard]] double warmth(std::size_t device) const noexcept SEXTANT_NONBLOCKING {
    return (temperatures_[device] - cold_) * per_kelvin_;
  }

  /// The current of a leg passes from the device of its last state to that of the next.
  void commutate(std::size_t leg, LegState state, double i) noexcept SEXTANT_NONBLOCKING {
    const LegState last = states_[leg];
    states_[leg] = state;
    if (state == last || std::abs(i) < no_current) return;
    const std::size_t from = place(leg, conducting_device(last, i > 0.0));
    const std::size_t to = place(leg, conducting_device(state, i > 0.0));
    if (from == to) return;
    if (is_switch(from)) {
      heat_[from] += switch_scale_ * turn_off_(i, warmth(from));
    } else {
      heat_[from] += diode_scale_ * recovery_(i, warmth(from));
    }
    if (is_switch(to)) heat_[to] += switch_scale_ * turn_on_(i, warmth(to));
  }

  /// A leg carries a current along a line.
  void conduct(std::size_t leg, LegState state, double from, double to,
               double seconds) noexcept SEXTANT_NONBLOCKING {
    if (from * to < 0.0) {
      const double before = seconds * from / (from - to);
      conduct(leg, state, from, 0.0, before);
      conduct(leg, state, 0.0, to, seconds - before);
      return;
    }
    const double middle = 0.5 * (from + to);
    if (std::abs(middle) < no_current) return;
    const std::size_t device = place(leg, conducting_device(state, middle > 0.0));
    const LossCurve& voltage = is_switch(device) ? switch_voltage_ : diode_voltage_;
    const double s = warmth(device);
    const auto simpson = [&](auto v) {
      const auto power = [&v](double i) { return v(i) * std::abs(i); };
      return seconds / 6.0 * (power(from) + 4.0 * power(middle) + power(to));
    };
    heat_[device] += simpson([&](double i) { return voltage(i, s); });
    if (!drops_.act()) return;
    dropped_ +=
        simpson([&](double i) { return drops_.threshold_voltage + drops_.slope_resistance * std::abs(i); });
  }

  void update_temperatures() noexcept SEXTANT_NONBLOCKING {
    const double base = case_temperature();
    for (std::size_t d = 0; d < inverter_devices; ++d) temperatures_[d] = base + junctions_[d].rise();
  }

  ConductionDrops<> drops_;
  LossCurve switch_voltage_, diode_voltage_;  ///< [V]
  LossCurve turn_on_, turn_off_, recovery_;   ///< [J]
  double cold_;                               ///< [°C]
  double per_kelvin_;                         ///< [1/K]
  double energy_voltage_;                     ///< [V]
  double switch_exponent_, diode_exponent_;   ///< [-]
  double ambient_;                            ///< [°C]
  FosterNetwork case_;
  PerDevice<FosterNetwork> junctions_{};
  PerDevice<double> temperatures_{};                                             ///< [°C]
  std::array<LegState, 3> states_{LegState::off, LegState::off, LegState::off};  ///< of the legs
  PerDevice<double> heat_{};                                                     ///< of the reading [J]
  double dropped_{};                       ///< lost in it by the drops [J]
  double seconds_{};                       ///< its length [s]
  double switch_scale_{}, diode_scale_{};  ///< (u/u_ref)^k [-]
  InverterEnergies energies_{};
  double power_{};        ///< of the last reading [W]
  double drawn_power_{};  ///< over the next one [W]
};

}  // namespace sextant
