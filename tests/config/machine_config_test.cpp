#include "sextant/config/machine_config.hpp"

#include <numbers>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;

InductionMachineParameters<> machine_of(const EcuConfig& config) {
  return config.drive.plant.plant.machine;
}

/// what() of the ConfigError that f throws.
template <class F>
std::string refusal(F f) {
  try {
    f();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(MachineConfig, ReactancesBecomeInductancesAtTheirFrequency) {
  MachineConfig config;
  config.x_m_ohm = 26.13;
  config.x_ls_ohm = 0.754;
  config.l_lr_h = 0.003;
  config.reactance_frequency_hz = 60.0;
  config.poles = 6;
  const auto machine = apply(config, {}, 50.0);
  EXPECT_NEAR(machine.l_m, 26.13 / (2.0 * std::numbers::pi * 60.0), 1e-15);
  EXPECT_NEAR(machine.l_ls, 0.754 / (2.0 * std::numbers::pi * 60.0), 1e-15);
  EXPECT_EQ(machine.l_lr, 0.003);
  EXPECT_EQ(machine.pole_pairs, 3);
  EXPECT_EQ(machine.r_s, InductionMachineParameters<>{}.r_s) << "what is not said stays";
}

TEST(MachineConfig, WithoutAFrequencyOfTheirOwnReactancesHoldAtTheGivenOne) {
  MachineConfig config;
  config.x_m_ohm = 10.0;
  EXPECT_NEAR(apply(config, {}, 25.0).l_m, 10.0 / (2.0 * std::numbers::pi * 25.0), 1e-15);
}

TEST(MachineConfig, TheShippedMachineIsTableTwo) {
  const ConfigFiles files;
  const std::string file = files.write("ecu.toml", "machine = \"" + shipped_machine + "\"\n");
  const auto machine = machine_of(load_ecu_config(file));
  const InductionMachineParameters<> paper;
  EXPECT_EQ(machine.r_s, 0.435);
  EXPECT_EQ(machine.r_r, 0.816);
  EXPECT_NEAR(machine.l_ls, paper.l_ls, 1e-9);
  EXPECT_NEAR(machine.l_lr, paper.l_lr, 1e-9);
  EXPECT_NEAR(machine.l_m, paper.l_m, 1e-6);
  EXPECT_EQ(machine.pole_pairs, 2);
  EXPECT_EQ(machine.inertia, 0.089);
}

TEST(MachineConfig, TheFilesOwnTableChangesTheMachineFile) {
  const ConfigFiles files;
  const std::string file =
      files.write("ecu.toml", "[machine]\nfile = \"" + shipped_machine + "\"\nr_s_ohm = 0.5\nl_m_h = 0.09\n");
  const auto machine = machine_of(load_ecu_config(file));
  EXPECT_EQ(machine.r_s, 0.5);
  EXPECT_EQ(machine.l_m, 0.09) << "an inductance replaces the machine file's reactance";
  EXPECT_EQ(machine.r_r, 0.816);
}

TEST(MachineConfig, TheEstimateFollowsTheMachineExceptWhereItIsToldOtherwise) {
  const EcuConfig config =
      load_ecu_config(shipped_ecu, {"machine.r_r_ohm=1.25", "control.machine_estimate.r_s_ohm=0.6",
                                    "control.machine_estimate.x_m_ohm=20"});
  const auto& estimate = config.drive.direct_torque().machine;
  EXPECT_EQ(machine_of(config).r_s, 0.435);
  EXPECT_EQ(machine_of(config).r_r, 1.25);
  EXPECT_EQ(estimate.r_s, 0.6);
  EXPECT_EQ(estimate.r_r, 1.25);
  EXPECT_NEAR(estimate.l_m, 20.0 / (100.0 * std::numbers::pi), 1e-15);
  EXPECT_EQ(estimate.l_ls, machine_of(config).l_ls);
}

TEST(MachineConfig, MistakesInTheMachineFileAreFoundThere) {
  const ConfigFiles files;
  const std::string ecu = files.write("ecu.toml", "machine = \"parts/motor.toml\"\n");
  const std::string motor = files.write("parts/motor.toml",
                                        "r_s_ohm = \"low\"\nr_r_ohm = 0.8\nx_ls_ohm = 0.7\nl_ls_h = 0.002\n"
                                        "x_m_ohm = 26.0\npoles = 4\nflux = 1\n");
  const std::string why = refusal([&] { (void)load_ecu_config(ecu); });
  EXPECT_THAT(why, HasSubstr(motor + ":1: r_s_ohm: expected a number"));
  EXPECT_THAT(why, HasSubstr(motor + ":4: l_ls_h: give this or x_ls_ohm, not both"));
  EXPECT_THAT(why, HasSubstr(motor + ":7: flux: unknown key"));
  EXPECT_THAT(why, HasSubstr(motor + ": x_lr_ohm: missing, expected a number here or in l_lr_h"));
  EXPECT_THAT(why, HasSubstr(motor + ": inertia_kg_m2: missing"));
}

TEST(MachineConfig, ReactancesNeedAFrequencyAndPolesComeInPairs) {
  const ConfigFiles files;
  const std::string reactances = "r_s_ohm = 1\nr_r_ohm = 1\nx_ls_ohm = 1\nx_lr_ohm = 1\nx_m_ohm = 30\n";
  const std::string motor = files.write("motor.toml", reactances + "poles = 3\ninertia_kg_m2 = 0.1\n");
  const std::string ecu = files.write("ecu.toml", "machine = \"motor.toml\"\n");
  const std::string why = refusal([&] { (void)load_ecu_config(ecu); });
  EXPECT_THAT(why, HasSubstr(motor));
  EXPECT_THAT(why, HasSubstr("the number of poles must be even"));
  EXPECT_THAT(why, HasSubstr("reactance_frequency_hz is missing"));
}

// A machine given in inductances has no frequency at which the estimate's reactances could hold.
TEST(MachineConfig, ReactancesOfTheEstimateNeedAFrequencyAsWell) {
  const ConfigFiles files;
  const std::string motor =
      files.write("motor.toml",
                  "r_s_ohm = 1\nr_r_ohm = 1\nl_ls_h = 0.002\nl_lr_h = 0.002\nl_m_h = 0.08\npoles = 4\n"
                  "inertia_kg_m2 = 0.1\n");
  const auto ecu = [&](const std::string& estimate) {
    return files.write("ecu.toml", "machine = \"" + motor +
                                       "\"\n[control]\nflux_reference_wb = 1\n[control.machine_estimate]\n" +
                                       estimate);
  };
  const std::string wrong = ecu("x_m_ohm = 30\n");
  EXPECT_EQ(
      refusal([&] { (void)load_ecu_config(wrong); }),
      wrong + ":4: control.machine_estimate: reactance_frequency_hz is missing, which the reactances need");
  const std::string right = ecu("x_m_ohm = 30\nreactance_frequency_hz = 60\n");
  EXPECT_NEAR(load_ecu_config(right).drive.direct_torque().machine.l_m, 30.0 / (120.0 * std::numbers::pi),
              1e-15);
  EXPECT_EQ(load_ecu_config(ecu("l_m_h = 0.07\n")).drive.direct_torque().machine.l_m, 0.07);
}

TEST(MachineConfig, AMachineFileThatIsNotThereIsNamedWhereItIsAskedFor) {
  const ConfigFiles files;
  const std::string ecu = files.write("ecu.toml", "drive_id = 1\nmachine = \"nowhere.toml\"\n");
  EXPECT_EQ(refusal([&] { (void)load_ecu_config(ecu); }),
            ecu + ":2: machine: the machine file " + files.path("nowhere.toml") + " does not exist");
  const std::string number = files.write("number.toml", "machine = 3\n");
  EXPECT_EQ(refusal([&] { (void)load_ecu_config(number); }),
            number + ":1: machine: expected the path of a machine file, got 3");
}

/// A machine file in inductances with the given lines.
std::string machine_file(const ConfigFiles& files, const std::string& name, const std::string& lines) {
  return files.write(name, "r_s_ohm = 1\nr_r_ohm = 2\npoles = 4\ninertia_kg_m2 = 0.1\n" + lines);
}

std::string ecu_file(const ConfigFiles& files, const std::string& machine, const std::string& more = {}) {
  return files.write("ecu.toml", "machine = \"" + machine + "\"\n[control]\nflux_reference_wb = 1\n" + more);
}

TEST(MachineConfig, OtherCircuitsBecomeTheTCircuit) {
  const ConfigFiles files;
  const std::string keys = "l_m_h = 0.1\nl_sigma_h = 0.01\n";
  for (const auto& [name, circuit_of] : {std::pair{"gamma", &gamma_circuit<double>},
                                         std::pair{"inverse_gamma", &inverse_gamma_circuit<double>}}) {
    SCOPED_TRACE(name);
    const std::string motor = machine_file(files, "motor.toml", keys + "circuit = \"" + name + "\"\n");
    const EcuConfig config = load_ecu_config(ecu_file(files, motor));
    const LeakageCircuit<> circuit = circuit_of(machine_of(config));
    EXPECT_NEAR(circuit.l_m, 0.1, 1e-15);
    EXPECT_NEAR(circuit.l_sigma, 0.01, 1e-15);
    EXPECT_NEAR(circuit.r_r, 2, 1e-14);
    EXPECT_EQ(machine_of(config).r_s, 1);
    EXPECT_EQ(machine_of(config).l_ls, machine_of(config).l_lr);
    EXPECT_EQ(config.drive.drive.torque_monitor.machine.r_r, machine_of(config).r_r) << "of every part";
    const std::string printed = print_config(config);
    EXPECT_THAT(printed, HasSubstr(std::string{"\ncircuit = \""} + name + "\""));
    const EcuConfig again = load_ecu_config(files.write("printed.toml", printed));
    EXPECT_EQ(print_config(again), printed);
    EXPECT_EQ(machine_of(again).l_m, machine_of(config).l_m);
  }
}

TEST(MachineConfig, ReactancesAreThoseOfTheCircuit) {
  const ConfigFiles files;
  const std::string motor = machine_file(
      files, "motor.toml",
      "circuit = \"inverse_gamma\"\nx_m_ohm = 30\nx_sigma_ohm = 4\nreactance_frequency_hz = 50\n");
  const LeakageCircuit<> circuit = inverse_gamma_circuit(machine_of(load_ecu_config(ecu_file(files, motor))));
  EXPECT_NEAR(circuit.l_m, 30 / (100 * std::numbers::pi), 1e-15);
  EXPECT_NEAR(circuit.l_sigma, 4 / (100 * std::numbers::pi), 1e-15);
}

TEST(MachineConfig, TheEstimateHasTheCircuitOfTheMachineUnlessItSaysAnother) {
  const ConfigFiles files;
  const std::string motor =
      machine_file(files, "motor.toml", "circuit = \"gamma\"\nl_m_h = 0.1\nl_sigma_h = 0.01\n");
  const auto estimate = [&](const std::string& lines) {
    const std::string file = ecu_file(files, motor, "[control.machine_estimate]\n" + lines);
    return load_ecu_config(file).drive.direct_torque().machine;
  };
  const auto unchanged = estimate("");
  const LeakageCircuit<> gamma = gamma_circuit(estimate("r_r_ohm = 3\n"));
  EXPECT_NEAR(gamma.r_r, 3, 1e-14);
  EXPECT_NEAR(gamma.l_m, 0.1, 1e-15);
  EXPECT_NEAR(gamma.l_sigma, 0.01, 1e-15);
  EXPECT_EQ(estimate("circuit = \"T\"\nr_r_ohm = 3\n").r_r, 3);
  EXPECT_EQ(estimate("circuit = \"T\"\nr_r_ohm = 3\n").l_ls, unchanged.l_ls);
  const LeakageCircuit<> inverse =
      inverse_gamma_circuit(estimate("circuit = \"inverse_gamma\"\nl_m_h = 0.08\n"));
  EXPECT_NEAR(inverse.l_m, 0.08, 1e-15);
  EXPECT_NEAR(inverse.l_sigma, inverse_gamma_circuit(unchanged).l_sigma, 1e-15);
  EXPECT_EQ(estimate("circuit = \"inverse_gamma\"\nr_s_ohm = 5\n").l_m, unchanged.l_m) << "to the bit";
}

TEST(MachineConfig, KeysOfAnotherCircuitAreRefused) {
  const ConfigFiles files;
  const auto why = [&](const std::string& lines) {
    const std::string motor = machine_file(files, "motor.toml", lines);
    return refusal([&, ecu = ecu_file(files, motor)] { (void)load_ecu_config(ecu); });
  };
  const std::string t = "l_ls_h = 0.01\nl_lr_h = 0.01\nl_m_h = 0.1\n";
  EXPECT_EQ(why(t), "accepted");
  EXPECT_THAT(
      why(t + "l_sigma_h = 0.01\n"),
      HasSubstr("motor.toml:8: l_sigma_h: the circuit of this machine is \"T\", which has l_ls_h and "
                "l_lr_h instead: give that and leave this key out of its file, or give another circuit"));
  const std::string gamma = "circuit = \"gamma\"\nl_m_h = 0.1\n";
  EXPECT_EQ(why(gamma + "l_sigma_h = 0.01\n"), "accepted");
  EXPECT_THAT(why(gamma),
              HasSubstr("motor.toml: x_sigma_ohm: missing, expected a number here or in l_sigma_h"));
  EXPECT_THAT(why(gamma + "l_sigma_h = 0.01\nl_lr_h = 0.005\n"),
              HasSubstr("motor.toml:8: l_lr_h: the circuit of this machine is \"gamma\", which has l_sigma_h "
                        "instead"));
  EXPECT_THAT(
      why("circuit = \"pi\"\n" + t),
      HasSubstr("motor.toml:5: circuit: expected \"T\" or \"gamma\" or \"inverse_gamma\", got \"pi\""));
  EXPECT_THAT(why(gamma + "l_sigma_h = 10\n"), HasSubstr("give all in the same unit"));
}

}  // namespace
}  // namespace sextant
