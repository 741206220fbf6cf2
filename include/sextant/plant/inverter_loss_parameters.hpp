#pragma once

#include <cmath>
#include <optional>
#include <string>

#include "sextant/core/description.hpp"
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

inline constexpr Axis loss_current{"current", 0, 1e5};

/// Curves of the voltage of a switch or diode. [V]
inline void describe_voltage(Description& d, const std::string& device, LossTable& table) {
  constexpr Axis volts{"voltage", 0, 1e3};
  const std::string meaning = "voltage of a " + device +
                              " that conducts, over the current in A, at cold_c; lines join the points and "
                              "go on beyond them; no points: no loss";
  d.points((device + "_v").c_str(), table.cold, loss_current, volts, "V", meaning.c_str());
  d.points((device + "_hot_v").c_str(), table.hot, loss_current, volts, "V",
           "the same at hot_c, with a line over the temperature; no points: as cold");
}

/// Curves of an energy of switching. [J]
inline void describe_energy(Description& d, const std::string& name, LossTable& table,
                            const std::string& what) {
  constexpr Axis millijoules{"energy", 0, 1e5};
  const std::string meaning =
      what + ", over the current in A, at cold_c and energy_voltage_v; no points: no loss";
  d.points((name + "_mj").c_str(), {table.cold, 1e-3}, loss_current, millijoules, "mJ", meaning.c_str());
  d.points((name + "_hot_mj").c_str(), {table.hot, 1e-3}, loss_current, millijoules, "mJ",
           "the same at hot_c; no points: as cold");
}

inline void describe_network(Description& d, const char* name, FosterPairs& pairs, const std::string& what) {
  const std::string meaning =
      what + ": pairs of thermal resistance in K/W and time constant, four at most; no pairs: no rise";
  d.points(name, pairs, {"resistance", 0, 1e4}, {"time constant", 0, 1e6}, "s", meaning.c_str());
}

inline void describe(Description& d, InverterLossParameters& p) {
  auto& [switch_voltage, diode_voltage, turn_on, turn_off, recovery, cold, hot, energy_voltage,
         switch_exponent, diode_exponent, switch_network, diode_network, case_network, ambient, start_case] =
      p;
  const auto temperature = [](const char* meaning) { return Quantity{"C", -100, 400, meaning}; };
  describe_voltage(d, "switch", switch_voltage);
  describe_voltage(d, "diode", diode_voltage);
  describe_energy(d, "turn_on", turn_on,
                  "energy that a switch loses as it turns on, that of its diode's recovery included");
  describe_energy(d, "turn_off", turn_off, "energy that a switch loses as it turns off");
  describe_energy(d, "recovery", recovery, "energy that a diode loses as it turns off");
  d.number("cold_c", cold, temperature("junction temperature of the first curve of each pair"));
  d.number("hot_c", hot, temperature("the same of the second one, above it"));
  d.number("energy_voltage_v", energy_voltage, {"V", 1, 1e5, "link voltage at which the energies hold"});
  d.number("switch_exponent", switch_exponent,
           {"", 0, 5, "of link voltage by energy_voltage_v in the energies of a switch"});
  d.number("diode_exponent", diode_exponent, {"", 0, 5, "the same of a diode"});
  describe_network(d, "switch_network", switch_network,
                   "Foster network from the junction of a switch to the case");
  describe_network(d, "diode_network", diode_network, "the same of a diode");
  describe_network(d, "case_network", case_network,
                   "the same from the case, common to all devices and heated by all, to the ambient");
  d.number("ambient_c", ambient, temperature("temperature of the ambient"));
  d.number("case_c", start_case, temperature("temperature of the case at the beginning; not set: ambient_c"));
}

}  // namespace sextant
