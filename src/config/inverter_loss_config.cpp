#include "sextant/config/inverter_loss_config.hpp"

#include <string>

namespace sextant {
namespace {

constexpr Range<double> junction_range_c{-100, 400};

/// A member of each pair, as messages name it.
struct Axis {
  const char* name;
  Range<double> range;
};

constexpr Axis current{"current", {0, 1e5}};

/// Pairs; the second member is the file's value times `scale`.
void pairs(Section& s, const std::string& key, PointsField::Pairs& member, const Axis& first,
           const Axis& second, const char* unit, const std::string& meaning, double scale = 1.0) {
  const auto get = [&member, scale] {
    PointsField::Pairs list = member;
    for (auto& [x, y] : list) y /= scale;
    return list;
  };
  const auto set = [&member, scale](const PointsField::Pairs& list) {
    member = list;
    for (auto& [x, y] : member) y *= scale;
  };
  s.add(key, unit, meaning.c_str(),
        PointsField{first.range, second.range, get, set, first.name, second.name});
}

void voltage(Section& s, const std::string& name, LossTable& table) {
  constexpr Axis volts{"voltage", {0, 1e3}};
  pairs(s, name + "_v", table.cold, current, volts, "V",
        "voltage of a " + name +
            " that conducts, over the current in A, at cold_c; lines join the points and go "
            "on beyond them; no points: no loss");
  pairs(s, name + "_hot_v", table.hot, current, volts, "V",
        "the same at hot_c, with a line over the temperature; no points: as cold");
}

void energy(Section& s, const std::string& name, LossTable& table, const std::string& meaning) {
  constexpr Axis millijoules{"energy", {0, 1e5}};
  pairs(s, name + "_mj", table.cold, current, millijoules, "mJ",
        meaning + ", over the current in A, at cold_c and energy_voltage_v; no points: no loss", 1e-3);
  pairs(s, name + "_hot_mj", table.hot, current, millijoules, "mJ", "the same at hot_c; no points: as cold",
        1e-3);
}

void network(Section& s, const std::string& key, FosterPairs& member, const std::string& meaning) {
  pairs(s, key, member, {"resistance", {0, 1e4}}, {"time constant", {0, 1e6}}, "s",
        meaning + ": pairs of thermal resistance in K/W and time constant, four at most; no pairs: no rise");
}

}  // namespace

void describe(Section s, InverterLossParameters& p) {
  voltage(s, "switch", p.switch_voltage);
  voltage(s, "diode", p.diode_voltage);
  energy(s, "turn_on", p.turn_on,
         "energy that a switch loses as it turns on, that of its diode's recovery included");
  energy(s, "turn_off", p.turn_off, "energy that a switch loses as it turns off");
  energy(s, "recovery", p.recovery, "energy that a diode loses as it turns off");
  s.number("cold_c", p.cold, junction_range_c, "C", "junction temperature of the first curve of each pair");
  s.number("hot_c", p.hot, junction_range_c, "C", "the same of the second one, above it");
  s.number("energy_voltage_v", p.energy_voltage, {1, 1e5}, "V", "link voltage at which the energies hold");
  s.number("switch_exponent", p.switch_exponent, {0, 5}, "",
           "of link voltage by energy_voltage_v in the energies of a switch");
  s.number("diode_exponent", p.diode_exponent, {0, 5}, "", "the same of a diode");
  network(s, "switch_network", p.switch_network, "Foster network from the junction of a switch to the case");
  network(s, "diode_network", p.diode_network, "the same of a diode");
  network(s, "case_network", p.case_network,
          "the same from the case, common to all devices and heated by all, to the ambient");
  s.number("ambient_c", p.ambient, junction_range_c, "C", "temperature of the ambient");
  s.number("case_c", p.start_case, junction_range_c, "C",
           "temperature of the case at the beginning; not set: ambient_c");
  s.check(p);
}

}  // namespace sextant
