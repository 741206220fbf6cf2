#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <unistd.h>

#include "sextant/config/load_config.hpp"
#include "sextant/config/make_controller.hpp"
#include "sextant/core/drive_limits.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"
#include "sextant/run/mil_runner.hpp"

namespace sextant {

/// A machine with its link and flux.
struct TestMachine {
  const char* name;
  InductionMachineParameters<> parameters;
  double u_dc;  ///< [V]
  double psi;   ///< stator flux reference [Wb]

  /// Speed at which the flux without torque meets the voltage limit. [rad/s]
  [[nodiscard]] double base_speed() const { return zero_torque_speed(parameters, psi, u_dc); }
};

/// From 0.25 kW to 200 kW, 311 V to 565 V, two to four pole pairs.
inline const std::array test_machines{
    TestMachine{"250 W", {25, 22, 0.06, 0.06, 1.1, 2, 3e-4}, 540, 0.9},
    TestMachine{"paper", {}, 530, 1.1},
    TestMachine{"7.5 kW", {0.72, 0.62, 0.0043, 0.0043, 0.152, 2, 0.03}, 560, 1.0},
    TestMachine{"8 poles", {0.467, 0.380, 0.0033, 0.0033, 0.039674, 4, 0.2066}, 311, 0.476},
    TestMachine{"traction", {0.010, 0.008, 40e-6, 40e-6, 1.5e-3, 2, 0.06}, 400, 0.1838},
    TestMachine{
        "45 kW", {0.057, 0.0316040816, 0.00112364373, 0.00112364373, 0.0255763563, 2, 0.8134}, 540, 1.04},
    TestMachine{"150 kW", {0.01379, 0.007728, 0.000152, 0.000152, 0.00769, 2, 2.9}, 565, 1.0383},
    TestMachine{"200 kW", {0.012, 0.009, 1.4e-4, 1.6e-4, 5.2e-3, 3, 4}, 560, 0.9},
};

/// How a machine runs.
struct MachineRun {
  std::string controller{"foc"};
  int period_us{50};
  double omega_m{};                ///< imposed [rad/s]
  double slope{};                  ///< of the imposed speed [rad/s²]
  double end_s{1.5};               ///< [s]
  double lead_us{};                ///< of the samples, as the drive and the sensors have it [us]
  std::string fault{"none"};       ///< of the plant, from the beginning
  std::string torque{"[[0, 0]]"};  ///< steps of the command [s, N·m]
  std::vector<std::string> set{};  ///< keys with other values, as "key=value"
};

/// With every default that follows from machine, link and period; the metrics' window is the last 100 ms.
inline ScenarioConfig machine_config(const TestMachine& machine, const MachineRun& r) {
  const InductionMachineParameters<>& m = machine.parameters;
  const auto number = [](double x) { return std::to_string(x * 1e6) + "e-6"; };
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("sextant_machine_run_" + std::to_string(getpid()) + ".toml");
  std::ofstream{file}
      << "name = \"machine_run\"\nduration_s = " << number(r.end_s)
      << "\n[machine]\nr_s_ohm = " << number(m.r_s) << "\nr_r_ohm = " << number(m.r_r)
      << "\nl_ls_h = " << number(m.l_ls) << "\nl_lr_h = " << number(m.l_lr) << "\nl_m_h = " << number(m.l_m)
      << "\npoles = " << 2 * m.pole_pairs << "\ninertia_kg_m2 = " << number(m.inertia)
      << "\n[control]\ncontroller = \"" << r.controller << "\"\nflux_reference_wb = " << number(machine.psi)
      << "\n[drive]\nperiod_us = " << r.period_us << "\nsampling_lead_us = " << number(r.lead_us)
      << "\n[plant]\nu_dc_v = " << number(machine.u_dc)
      << "\nintegrator = \"exact\"\n[plant.faults]\nkind = \"" << r.fault
      << "\"\n[load]\nkind = \"imposed_speed\"\n[load.speed_rad_s]\nshape = \"linear\"\npoints = [[0, "
      << number(r.omega_m) << "], [" << number(r.end_s) << ", " << number(r.omega_m + r.slope * r.end_s)
      << "]]\n[profile.torque_nm]\nshape = \"steps\"\npoints = " << r.torque
      << "\n[metrics]\nwindow_from_s = " << number(r.end_s - 0.1) << '\n';
  const ScenarioConfig config = load_scenario_config(file.string(), r.set);
  std::filesystem::remove(file);
  return config;
}

inline MilResult run(const ScenarioConfig& config) {
  MeteredPowerStage power_stage{config.drive.plant, config.scenario.load};
  const auto controller = make_controller(config.drive);
  Drive<double> drive{config.drive.drive, *controller};
  return MilRunner{drive, power_stage.io(), config.drive.drive.period_ns}.run(config.scenario, nullptr, {});
}

inline MilResult run(const TestMachine& machine, const MachineRun& r) {
  return run(machine_config(machine, r));
}

}  // namespace sextant
