#include "sextant/config/machine_config.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "number_text.hpp"

namespace sextant {
namespace {

constexpr Range<double> resistance_ohm{1e-6, 1e4};
constexpr Range<double> reactance_ohm{1e-6, 1e5};
constexpr Range<double> inductance_h{1e-9, 1e3};
constexpr Range<double> frequency_hz{1e-2, 1e4};
constexpr Range<double> inertia_kg_m2{1e-9, 1e5};

/// Two keys for one inductance; the one set last replaces the other of an earlier file.
void inductance(Section& s, const std::string& x_key, std::optional<double>& x, const std::string& l_key,
                std::optional<double>& l, const std::string& name, const std::string& otherwise) {
  const std::string x_meaning = name + " reactance" + otherwise;
  const std::string l_meaning = name + " inductance, instead of the reactance" + otherwise;
  s.add(x_key, "ohm", x_meaning.c_str(),
        NumberField{reactance_ohm, [&x] { return x; },
                    [&x, &l](double v) {
                      x = v;
                      l.reset();
                    }});
  s.add(l_key, "H", l_meaning.c_str(),
        NumberField{inductance_h, [&l] { return l; },
                    [&x, &l](double v) {
                      l = v;
                      x.reset();
                    }});
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
  const auto needed = [&s, complete] {
    if (complete) s.required();
  };
  s.number("r_s_ohm", c.r_s_ohm, resistance_ohm, "ohm", ("stator resistance" + otherwise).c_str());
  needed();
  s.number("r_r_ohm", c.r_r_ohm, resistance_ohm, "ohm",
           ("rotor resistance, referred to the stator" + otherwise).c_str());
  needed();
  inductance(s, "x_ls_ohm", c.x_ls_ohm, "l_ls_h", c.l_ls_h, "stator leakage", otherwise);
  inductance(s, "x_lr_ohm", c.x_lr_ohm, "l_lr_h", c.l_lr_h, "rotor leakage", otherwise);
  inductance(s, "x_m_ohm", c.x_m_ohm, "l_m_h", c.l_m_h, "magnetising", otherwise);
  s.number("reactance_frequency_hz", c.reactance_frequency_hz, frequency_hz, "Hz",
           ("frequency at which the reactances hold" + otherwise).c_str());
  s.integer("poles", c.poles, {2, 200}, "", ("number of poles, twice the pole pairs" + otherwise).c_str());
  needed();
  s.number("inertia_kg_m2", c.inertia_kg_m2, inertia_kg_m2, "kg·m²",
           ("inertia of rotor and shaft" + otherwise).c_str());
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
