#include "sextant/config/machine_config.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "number_text.hpp"

namespace sextant {
namespace {

constexpr std::array circuits{Choice{"T", MachineCircuit::t}, Choice{"gamma", MachineCircuit::gamma},
                              Choice{"inverse_gamma", MachineCircuit::inverse_gamma}};

const char* name_of(MachineCircuit circuit) {
  return std::ranges::find(circuits, circuit, &Choice<MachineCircuit>::value)->name;
}

/// A machine's table while it is described.
struct MachineKeys {
  Section& s;
  MachineConfig& c;
  const MachineConfig& complete;  ///< whose reactances' frequency is that of these too
  std::string otherwise;          ///< what a text says of a key that is not set; empty where all must be set
  std::function<MachineCircuit()> circuit;  ///< in force

  [[nodiscard]] bool must_be_complete() const { return otherwise.empty(); }
};

/// A number that is an inductance of some circuits only.
void check_circuit(const MachineKeys& k, const std::string& key, const std::optional<double>& x,
                   std::function<bool(MachineCircuit)> has) {
  k.s.section(key).check([&x, circuit = k.circuit, has = std::move(has)]() -> std::string {
    if (!x || has(circuit())) return {};
    return std::string{"the circuit of this machine is \""} + name_of(circuit()) + "\", which has " +
           (circuit() == MachineCircuit::t ? "l_ls_h and l_lr_h instead" : "l_sigma_h instead") +
           ": give that and leave this key out of its file, or give another circuit";
  });
}

/// Two keys for one inductance; the one set last replaces the other of an earlier file. has: whether a
/// circuit has it.
void inductance(const MachineKeys& k, const std::string& x_key, std::optional<double>& x,
                const std::string& l_key, std::optional<double>& l, const std::string& name,
                const std::function<bool(MachineCircuit)>& has) {
  const auto either = [&s = k.s](const std::string& key, std::optional<double>& given,
                                 std::optional<double>& other, const Quantity& q) {
    s.add(key, q.unit, q.meaning, NumberKind{{q.min, q.max}},
          {[&given] { return given; },
           [&given, &other](const Value& value) {
             given = std::get<double>(value);
             other.reset();
           }});
  };
  either(x_key, x, l, {"ohm", 1e-6, 1e5, (name + " reactance" + k.otherwise).c_str()});
  either(l_key, l, x,
         {"H", 1e-9, 1e3, (name + " inductance, instead of the reactance" + k.otherwise).c_str()});
  k.s.alternative(x_key, l_key, [complete = k.must_be_complete(), circuit = k.circuit, has] {
    return complete && has(circuit());
  });
  check_circuit(k, x_key, x, has);
  check_circuit(k, l_key, l, has);
}

void describe_inductances(const MachineKeys& k) {
  const auto in_t = [](MachineCircuit circuit) { return circuit == MachineCircuit::t; };
  const auto in_others = [](MachineCircuit circuit) { return circuit != MachineCircuit::t; };
  const auto in_all = [](MachineCircuit) { return true; };
  MachineConfig& c = k.c;
  inductance(k, "x_ls_ohm", c.x_ls_ohm, "l_ls_h", c.l_ls_h, "stator leakage", in_t);
  inductance(k, "x_lr_ohm", c.x_lr_ohm, "l_lr_h", c.l_lr_h, "rotor leakage", in_t);
  inductance(k, "x_sigma_ohm", c.x_sigma_ohm, "l_sigma_h", c.l_sigma_h, "leakage", in_others);
  inductance(k, "x_m_ohm", c.x_m_ohm, "l_m_h", c.l_m_h, "magnetising", in_all);
}

void describe_keys(const MachineKeys& k) {
  const auto number = [&k](const char* key, std::optional<double>& x, const char* unit, Range<double> range,
                           const char* meaning) {
    k.s.number(key, x, {unit, range.min, range.max, (meaning + k.otherwise).c_str()});
  };
  const auto needed = [&k] {
    if (k.must_be_complete()) k.s.required();
  };
  MachineConfig& c = k.c;
  number("r_s_ohm", c.r_s_ohm, "ohm", {1e-6, 1e4}, "stator resistance");
  needed();
  k.s.choice(
      "circuit", c.circuit, circuits,
      "equivalent circuit whose inductances and rotor resistance the keys are; gamma, inverse_gamma: all "
      "leakage, l_sigma_h, on the rotor's, on the stator's side" +
          k.otherwise,
      k.must_be_complete() ? name_of(MachineCircuit::t) : nullptr);
  number("r_r_ohm", c.r_r_ohm, "ohm", {1e-6, 1e4}, "rotor resistance, referred to the stator");
  needed();
  describe_inductances(k);
  number("reactance_frequency_hz", c.reactance_frequency_hz, "Hz", {1e-2, 1e4},
         "frequency at which the reactances hold");
  k.s.add("poles", "", "number of poles, twice the pole pairs" + k.otherwise, IntegerKind{{2, 200}},
          {[&c] { return c.poles; }, [&c](const Value& x) { c.poles = int(std::get<std::int64_t>(x)); }});
  needed();
  number("inertia_kg_m2", c.inertia_kg_m2, "kg·m²", {1e-9, 1e5}, "inertia of rotor and shaft");
  needed();
  k.s.check(c);
  k.s.check([&c, &complete = k.complete]() -> std::string {
    if (!c.has_reactance() || c.reactance_frequency_hz || complete.reactance_frequency_hz) return {};
    return "reactance_frequency_hz is missing, which the reactances need";
  });
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
         " H; machines have 5 to 50: give all in the same unit, henry (or ohm)";
}

/// Sets an inductance that is given, as such or as a reactance at `omega` [rad/s].
void set_inductance(double& l, std::optional<double> x_ohm, std::optional<double> l_h, double omega) {
  if (x_ohm) l = *x_ohm / omega;
  if (l_h) l = *l_h;
}

InductionMachineParameters<> apply_t(const MachineConfig& c, InductionMachineParameters<> machine,
                                     double omega) {
  machine.r_r = c.r_r_ohm.value_or(machine.r_r);
  set_inductance(machine.l_ls, c.x_ls_ohm, c.l_ls_h, omega);
  set_inductance(machine.l_lr, c.x_lr_ohm, c.l_lr_h, omega);
  set_inductance(machine.l_m, c.x_m_ohm, c.l_m_h, omega);
  return machine;
}

/// Whether an element of a circuit with all leakage in one place is given.
bool changes_rotor(const MachineConfig& c) {
  return c.r_r_ohm || c.x_sigma_ohm || c.l_sigma_h || c.x_m_ohm || c.l_m_h;
}

LeakageCircuit<> changed(LeakageCircuit<> circuit, const MachineConfig& c, double omega) {
  circuit.r_r = c.r_r_ohm.value_or(circuit.r_r);
  set_inductance(circuit.l_sigma, c.x_sigma_ohm, c.l_sigma_h, omega);
  set_inductance(circuit.l_m, c.x_m_ohm, c.l_m_h, omega);
  return circuit;
}

}  // namespace

std::string MachineConfig::validate() const {
  if (poles && *poles % 2 != 0) return "the number of poles must be even";
  return {};
}

void describe(Section s, MachineConfig& c) {
  const auto circuit = [&c] { return c.circuit.value_or(MachineCircuit::t); };
  const MachineKeys keys{s, c, c, "", circuit};
  describe_keys(keys);
  s.check_basis("", [&c] { return inductance_problem(c); });
}

void describe_changes(Section s, MachineConfig& c, const MachineConfig& machine, const std::string& unset,
                      const std::function<MachineCircuit()>& circuit) {
  const MachineKeys keys{s, c, machine, "; not set: " + unset,
                         [&c, circuit] { return c.circuit ? *c.circuit : circuit(); }};
  describe_keys(keys);
}

InductionMachineParameters<> apply(const MachineConfig& c, InductionMachineParameters<> machine,
                                   double reactance_frequency_hz, MachineCircuit circuit) {
  const double omega = 2.0 * std::numbers::pi * c.reactance_frequency_hz.value_or(reactance_frequency_hz);
  machine.r_s = c.r_s_ohm.value_or(machine.r_s);
  if (c.poles) machine.pole_pairs = *c.poles / 2;
  machine.inertia = c.inertia_kg_m2.value_or(machine.inertia);
  switch (c.circuit.value_or(circuit)) {
    case MachineCircuit::t:
      return apply_t(c, machine, omega);
    case MachineCircuit::gamma:
      return changes_rotor(c) ? from_gamma(machine, changed(gamma_circuit(machine), c, omega)) : machine;
    case MachineCircuit::inverse_gamma:
      break;
  }
  return changes_rotor(c) ? from_inverse_gamma(machine, changed(inverse_gamma_circuit(machine), c, omega))
                          : machine;
}

}  // namespace sextant
