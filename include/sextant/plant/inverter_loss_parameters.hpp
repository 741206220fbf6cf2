#pragma once

#include <cmath>
#include <optional>

#include "sextant/plant/foster_network.hpp"
#include "sextant/plant/loss_curve.hpp"

namespace sextant {

/// A curve at two temperatures.
struct LossTable {
  LossPoints cold{};  ///< at `InverterLossParameters::cold`
  LossPoints hot{};   ///< at `hot`; none: as cold

  friend bool operator==(const LossTable&, const LossTable&) = default;
};

/// Losses of the inverter's switches and diodes by the curves of a data sheet, and their thermal networks
/// (`InverterLosses`). None by default.
struct InverterLossParameters {
  LossTable switch_voltage{};          ///< of a switch that conducts [V]
  LossTable diode_voltage{};           ///< of a diode that conducts [V]
  LossTable turn_on{};                 ///< energy of a switch that turns on [J]
  LossTable turn_off{};                ///< energy of a switch that turns off [J]
  LossTable recovery{};                ///< energy of a diode that turns off [J]
  double cold{25};                     ///< junction temperature at which the cold points hold [°C]
  double hot{125};                     ///< the same of the hot ones [°C]
  double energy_voltage{600};          ///< link voltage at which the energies hold [V]
  double switch_exponent{1.3};         ///< of the voltage in the energies of a switch [-]
  double diode_exponent{0.6};          ///< the same of a diode [-]
  FosterPairs switch_network{};        ///< junction of a switch to the case
  FosterPairs diode_network{};         ///< junction of a diode to the case
  FosterPairs case_network{};          ///< case, common to all, to the ambient, by the losses of all devices
  double ambient{40};                  ///< [°C]
  std::optional<double> start_case{};  ///< temperature of the case at the beginning; empty: ambient [°C]

  friend bool operator==(const InverterLossParameters&, const InverterLossParameters&) = default;

  [[nodiscard]] bool acts() const noexcept {
    return !switch_voltage.cold.empty() || !diode_voltage.cold.empty() || !turn_on.cold.empty() ||
           !turn_off.cold.empty() || !recovery.cold.empty();
  }

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    for (const LossTable* table : {&switch_voltage, &diode_voltage, &turn_on, &turn_off, &recovery}) {
      if (const char* problem = validate_points(table->cold)) return problem;
      if (const char* problem = validate_points(table->hot)) return problem;
      if (table->cold.empty() && !table->hot.empty())
        return "a curve at hot_c needs the same curve at cold_c beside it";
    }
    for (const FosterPairs* pairs : {&switch_network, &diode_network, &case_network}) {
      if (const char* problem = validate_pairs(*pairs)) return problem;
    }
    for (const double x : {cold, hot, ambient, start_case.value_or(ambient)}) {
      if (!std::isfinite(x)) return "the temperatures of the inverter's losses must be finite";
    }
    if (!(hot > cold)) return "hot_c must be above cold_c";
    if (!(std::isfinite(energy_voltage) && energy_voltage > 0.0))
      return "energy_voltage_v must be above zero";
    for (const double x : {switch_exponent, diode_exponent}) {
      if (!(std::isfinite(x) && x >= 0.0))
        return "the exponents of the voltage must be finite and not below zero";
    }
    if (start_case && *start_case != ambient && case_network.empty())
      return "case_c needs a network from case to ambient, or must be ambient_c";
    if (acts() || *this == InverterLossParameters{}) return nullptr;
    return "networks, temperatures and voltages of the inverter's losses need a curve over the current";
  }
};

}  // namespace sextant
