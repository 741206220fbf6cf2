#include <csignal>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <optional>
#include <string>
#include <vector>

#include "common/command_line.hpp"
#include "common/live_program.hpp"
#include "common/process_setup.hpp"
#include "common/program.hpp"
#include "plant/plant.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace {

constexpr const char* program_name = "sextant-plant";

constexpr const char* examples = R"(Examples:
  sextant-plant                                 configs/plant.toml as it stands
  sextant-ecu configs/ecu_hil.toml              the drive that belongs to it, in another shell
  sextant-plant --set hil.pacing=lockstep       virtual time: the plant waits for the drive
  sextant-plant --duration 10 --set period_us=250 --set load.torque_nm.value=5
  sextant-plant --print-config                  every key with unit, range and meaning
It ends on SIGINT, SIGTERM or SIGHUP. Without a running drive its gates are off.
)";

/// Returns on a signal, at the end of the duration, or when the plant has ended.
void run_until_end(sextant::plant::Plant& plant, const sigset_t& signals, std::optional<double> duration_s) {
  constexpr timespec poll_interval{0, 20'000'000};
  const std::int64_t begin_ns = sextant::now_ns();
  const double limit_ns = duration_s.value_or(1e9) * 1e9;
  while (double(sextant::now_ns() - begin_ns) < limit_ns && !plant.ended()) {
    if (sigtimedwait(&signals, nullptr, &poll_interval) > 0) return;
    plant.log_events();
    plant.poll_faults();
  }
}

int run(const sextant::LiveOptions& options) {
  const sextant::PlantConfig config = sextant::load_plant_config(options.config, options.overrides);
  if (options.print_config) {
    std::fputs(sextant::print_config(config).c_str(), stdout);
    return sextant::ExitStatus::done;
  }
  // Blocked before any thread starts, so that only run_until_end gets them.
  const sigset_t signals = sextant::block_leave_signals();
  sextant::RealtimeParameters realtime = config.realtime;
  if (config.hil.pacing == sextant::Pacing::lockstep) realtime.cpu = -1;  // no thread is bound to one
  sextant::set_up_process(realtime);
  sextant::plant::Plant plant{config, options.fault_socket,
                              [&options](const std::vector<std::string>& faults) {
                                std::vector<std::string> overrides = options.overrides;
                                overrides.insert(overrides.end(), faults.begin(), faults.end());
                                return sextant::load_plant_config(options.config, overrides).plant.io.fault;
                              }};
  plant.start();
  run_until_end(plant, signals, options.duration_s);
  plant.stop();
  plant.log_events();
  plant.print_report(stdout);
  return sextant::status_after(program_name, plant.problem());
}

}  // namespace

int main(int argc, char** argv) {
  sextant::start_log(program_name);
  sextant::LiveOptions options{.config = "configs/plant.toml"};
  const std::string help = examples + sextant::exit_status_table();
  const sextant::CommandLine line{program_name,
                                  "Sextant: the plant in a process of its own, for a drive in another one.",
                                  help.c_str(), sextant::live_options(options, "end after this time [s]")};
  if (const std::optional<int> status = line.parse(argc, argv)) return *status;
  return sextant::run_program(program_name, [&] { return run(options); });
}
