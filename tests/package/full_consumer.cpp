// The compiled folders: a scenario from its file, run with CVODE; and the CAN contract.
#include <cmath>
#include <cstdio>

#include "sextant/comms/command_receiver.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/config/make_controller.hpp"
#include "sextant/power_stage/simulated_power_stage.hpp"
#include "sextant/run/mil_runner.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const sextant::ScenarioConfig config = sextant::load_scenario_config(argv[1], {"duration_s=0.3"});
  sextant::MeteredPowerStage power_stage{config.drive.plant, config.scenario.load};
  const auto controller = sextant::make_controller(config.drive);
  sextant::Drive<double> drive{config.drive.drive, *controller};
  sextant::MilRunner runner{drive, power_stage.io(), config.drive.drive.period_ns};
  const double bias = runner.run(config.scenario, nullptr, {}).metrics[sextant::Metric::torque_bias];
  std::printf("torque bias %.2f N·m, command state %d\n", bias,
              int(sextant::CommandReceiver{}.command().e2e));
  return std::abs(bias) < 3.0 ? 0 : 1;
}
