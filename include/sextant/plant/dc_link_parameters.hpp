#pragma once

#include <cmath>
#include <optional>

#include "sextant/core/description.hpp"

namespace sextant {

/// A DC link with a capacitor, behind a source with resistance and inductance, with a brake chopper and a
/// pre-charge resistor, which the main contactor bypasses. None by default: the link is stiff.
template <class T = double>
struct DcLinkParameters {
  T capacitance{};                     ///< C; 0: the link is stiff, and nothing else counts [F]
  T source_resistance{};               ///< R, in series with the source [Ω]
  T source_inductance{};               ///< L, the same; 0: none [H]
  bool source_diode{false};            ///< the source is a rectifier: its current does not reverse [-]
  T chopper_resistance{};              ///< R_b across the link while the chopper is on; 0: no chopper [Ω]
  T chopper_on{};                      ///< link voltage at which the chopper turns on [V]
  T chopper_off{};                     ///< link voltage at which it turns off, below the other one [V]
  std::optional<T> initial_voltage{};  ///< of the capacitor; not set: that of the source [V]
  T precharge_resistance{};  ///< R_p, in series with the source until the main contactor closes; 0: none [Ω]
  T contactor_share{T(0.95)};  ///< of the source's voltage, at which link voltage the contactor closes [-]

  friend constexpr bool operator==(const DcLinkParameters&, const DcLinkParameters&) noexcept = default;

  /// True where the link voltage is a state.
  [[nodiscard]] constexpr bool acts() const noexcept { return capacitance > T(0); }
  [[nodiscard]] constexpr bool has_chopper() const noexcept { return acts() && chopper_resistance > T(0); }
  [[nodiscard]] constexpr bool has_precharge() const noexcept {
    return acts() && precharge_resistance > T(0);
  }

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    for (const T x : {capacitance, source_resistance, source_inductance, chopper_resistance, chopper_on,
                      chopper_off, initial_voltage.value_or(T(0)), precharge_resistance}) {
      if (!(std::isfinite(x) && x >= T(0)))
        return "capacitance, resistances, inductance and voltages of the DC link must be finite and not "
               "below zero";
    }
    if (!acts()) {
      return *this == DcLinkParameters{}
                 ? nullptr
                 : "a source with resistance, inductance or diode, a brake chopper and a pre-charge need a "
                   "DC link with a capacitance above zero";
    }
    if (!(source_resistance > T(0)))
      return "the resistance of the source must be above zero where the DC link has a capacitance";
    if (has_chopper() && !(chopper_off > T(0) && chopper_off < chopper_on))
      return "the brake chopper must turn off at a voltage above zero and below that at which it turns on";
    if (!has_chopper() && (chopper_on > T(0) || chopper_off > T(0)))
      return "the voltages of the brake chopper need a resistance of it above zero";
    if (!(contactor_share > T(0) && contactor_share < T(1)))
      return "the contactor must close at a share of the source's voltage between 0 and 1";
    if (!has_precharge() && contactor_share != DcLinkParameters{}.contactor_share)
      return "the share at which the contactor closes needs a pre-charge resistance above zero";
    return nullptr;
  }
};

template <class T>
void describe(Description& d, DcLinkParameters<T>& p) {
  auto& [capacitance, source_resistance, source_inductance, source_diode, chopper_resistance, chopper_on,
         chopper_off, initial_voltage, precharge_resistance, contactor_share] = p;
  d.number("capacitance_f", capacitance,
           {"F", 0, 1e3,
            "of the DC link, whose voltage is then a state that begins at u_dc_v; integrators stop at each "
            "switching, and exact is fixed; 0: the link is stiff"});
  d.number("source_ohm", source_resistance,
           {"ohm", 0, 1e6, "in series with the source of u_dc_v; above 0 where capacitance_f is not 0"});
  d.number("source_h", source_inductance, {"H", 0, 1e3, "the same, inductance; 0: none"});
  d.flag("source_diode", source_diode, "the source is a rectifier, which takes no current back");
  d.number("chopper_ohm", chopper_resistance,
           {"ohm", 0, 1e6, "resistor that the brake chopper puts across the link; 0: no chopper"});
  d.number("chopper_on_v", chopper_on, {"V", 0, 1e5, "link voltage at which the brake chopper turns on"});
  d.number("chopper_off_v", chopper_off,
           {"V", 0, 1e5, "link voltage at which it turns off, between u_dc_v and chopper_on_v"});
  d.number("initial_v", initial_voltage,
           {"V", 0, 2e4, "voltage of the capacitor at the beginning; not set: u_dc_v"});
  d.number("precharge_ohm", precharge_resistance,
           {"ohm", 0, 1e6,
            "pre-charge resistor, in series with the source until the main contactor bypasses it; 0: none"});
  d.number("contactor_share", contactor_share,
           {"", 0.01, 0.999,
            "link voltage by that of the source at which the main contactor closes, to stay closed"});
}

}  // namespace sextant
