#include "sextant/config/machine_config.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "number_text.hpp"

namespace sextant {
namespace {

/// Two keys for one inductance; the one set last replaces the other of an earlier file.
void inductance(Section& s, const std::string& x_key, std::optional<double>& x, const std::string& l_key,
                std::optional<double>& l, const std::string& name, const std::string& otherwise) {
  const auto either = [&s](const std::string& key, std::optional<double>& given, std::optional<double>& other,
                           const Quantity& q) {
    s.add(key, q.unit, q.meaning,
          NumberField{{q.min, q.max},
                      [&given] { return given; },
                      [&given, &other](double value) {
                        given = value;
                        other.reset();
                      }});
  };
  either(x_key, x, l, {"ohm", 1e-6, 1e5, (name + " reactance" + otherwise).c_str()});
  either(l_key, l, x, {"H", 1e-9, 1e3, (name + " inductance, instead of the reactance" + otherwise).c_str()});
  s.alternative(x_key, l_key, otherwise.empty());
}

/// L_m by the sum of the leakage inductances. Published machines have 6 to 30; outside of this range by far
/// more than a machine can, one of the three is in another unit. [-]
constexpr Range<double> magnetising_by_leakage{0.5, 500};

/// Empty where the inductances of a complete machine can be those of one machine, else a sentence.
std::string inductance_problem(const MachineConfig& c) {
  if (c.has_reactance() && !c.reactance_frequency_hz) return {};
  const InductionMachineParameters<> m = apply(c, {}, 50.0);
  const double ratio = m.l_m / (m.l_ls + m.l_lr);
  if (ratio >= magnetising_by_leakage.min && ratio <= magnetising_by_leakage.max) return {};
  return "the magnetising inductance, " + number_text(m.l_m) + " H, is " + rounded_text(ratio) +
         " times the leakage inductances of stator and rotor together, " + rounded_text(m.l_ls + m.l_lr) +
         " H; machines have 5 to 50: give all three in the same unit, henry (or ohm)";
}

}  // namespace

std::string MachineConfig::validate() const {
  if (poles && *poles % 2 != 0) return "the number of poles must be even";
  return {};
}

void describe(Section s, MachineConfig& c, const std::string& unset) {
  const bool complete = unset.empty();
  const std::string otherwise = complete ? "" : "; not set: " + unset;
  const auto number = [&](const char* key, std::optional<double>& x, const char* unit, Range<double> range,
                          const char* meaning) {
    s.number(key, x, {unit, range.min, range.max, (meaning + otherwise).c_str()});
  };
  const auto needed = [&s, complete] {
    if (complete) s.required();
  };
  number("r_s_ohm", c.r_s_ohm, "ohm", {1e-6, 1e4}, "stator resistance");
  needed();
  number("r_r_ohm", c.r_r_ohm, "ohm", {1e-6, 1e4}, "rotor resistance, referred to the stator");
  needed();
  inductance(s, "x_ls_ohm", c.x_ls_ohm, "l_ls_h", c.l_ls_h, "stator leakage", otherwise);
  inductance(s, "x_lr_ohm", c.x_lr_ohm, "l_lr_h", c.l_lr_h, "rotor leakage", otherwise);
  inductance(s, "x_m_ohm", c.x_m_ohm, "l_m_h", c.l_m_h, "magnetising", otherwise);
  number("reactance_frequency_hz", c.reactance_frequency_hz, "Hz", {1e-2, 1e4},
         "frequency at which the reactances hold");
  s.add("poles", "", ("number of poles, twice the pole pairs" + otherwise).c_str(),
        IntegerField{{2, 200},
                     [&c]() -> std::optional<std::int64_t> { return c.poles; },
                     [&c](std::int64_t x) { c.poles = int(x); }});
  needed();
  number("inertia_kg_m2", c.inertia_kg_m2, "kg·m²", {1e-9, 1e5}, "inertia of rotor and shaft");
  needed();
  s.check(c);
  if (complete) {
    s.check([&c]() -> std::string {
      if (!c.has_reactance() || c.reactance_frequency_hz) return {};
      return "reactance_frequency_hz is missing, which the reactances need";
    });
    s.check_basis("", [&c] { return inductance_problem(c); });
  }
}

InductionMachineParameters<> apply(const MachineConfig& c, InductionMachineParameters<> machine,
                                   double reactance_frequency_hz) {
  const double omega = 2.0 * std::numbers::pi * c.reactance_frequency_hz.value_or(reactance_frequency_hz);
  const auto inductance = [omega](double& member, std::optional<double> x, std::optional<double> l) {
    if (x) member = *x / omega;
    if (l) member = *l;
  };
  machine.r_s = c.r_s_ohm.value_or(machine.r_s);
  machine.r_r = c.r_r_ohm.value_or(machine.r_r);
  inductance(machine.l_ls, c.x_ls_ohm, c.l_ls_h);
  inductance(machine.l_lr, c.x_lr_ohm, c.l_lr_h);
  inductance(machine.l_m, c.x_m_ohm, c.l_m_h);
  if (c.poles) machine.pole_pairs = *c.poles / 2;
  machine.inertia = c.inertia_kg_m2.value_or(machine.inertia);
  return machine;
}

}  // namespace sextant
