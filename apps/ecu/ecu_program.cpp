#include "sextant/ecu/ecu_program.hpp"

#include <csignal>
#include <cstdio>
#include <ctime>
#include <deque>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "common/command_line.hpp"
#include "common/exit_status.hpp"
#include "common/live_program.hpp"
#include "common/process_setup.hpp"
#include "common/program.hpp"
#include "ecu/ecu.hpp"
#include "ecu/replay/cycle_replay.hpp"
#include "ecu/unit/contract_fit.hpp"
#include "ecu/unit/power_stage.hpp"
#include "ecu/virtual_time/scenario_run.hpp"
#include "ecu/virtual_time/virtual_run.hpp"
#include "reports/status_table.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/run/verdict.hpp"

namespace {

struct Options {
  std::string program{};
  sextant::EcuExtensions own{};
  sextant::LiveOptions live{.config = "configs/ecu.toml"};
  std::optional<std::string> can{};
  std::string timing_out{};
  std::string replay{};
  bool virtual_time{false};
  std::vector<std::string> log{};  // none or one
  sextant::ecu::VirtualRunOptions virtual_run{};
  sextant::ecu::ScenarioRunOptions scenario_run{};
  std::string set_socket{};
};

/// For the name of the program.
constexpr const char* examples = R"(Examples:
  {0}                                        configs/ecu.toml as it stands
  {0} --can udp_multicast:239.74.163.2:43113 a bus for machines without CAN
  {0} --duration 10 --set drive.flux_optimum=min_loss --set realtime.priority=90
  {0} configs/ecu_four.toml                  four drives on one bus
  {0} --print-config                         every key with unit, range and meaning
  {0} --virtual-time --profile configs/profiles/demo.csv --frames-out run.log
                                                     without CAN, DDS and clock, as fast as the machine allows
  {0} --virtual-time --scenario configs/scenarios/reversal.toml --junit out/junit.xml
                                                     a scenario with its limits, over the bus
  {0} --virtual-time run.log --telemetry-out run.csv
                                                     the same from a recording of candump -l or python-can
  {0} --duration 10 --record-cycles run.h5   every control period, to be run again
  {0} --duration 60 --set-socket /tmp/set    and scripts/set /tmp/set protection.over_current_a=80
  {0} --replay run.h5                        identical switching?
  {0} --replay run.h5 --set protection.over_speed_rad_s=60
                                                     what another limit would have done
It ends on SIGINT, SIGTERM or SIGHUP: torque to zero, gates off.
)";

/// The statuses of every program, and a line for each verdict that a run in virtual time or a replay may
/// have.
std::string status_table() {
  using sextant::Verdict;
  const auto line = [](Verdict verdict, const char* meaning) {
    return sextant::exit_status_line(sextant::exit_status(verdict), to_string(verdict), meaning);
  };
  return sextant::exit_status_table() + "With --virtual-time or --replay too:\n" +
         line(Verdict::tripped, "the drive was in FAULT at the end, also of a recording that is played") +
         line(Verdict::no_torque, "the drive did not get ready for the profile") +
         line(Verdict::fail, "with --replay: a gate pattern is not the recorded one") +
         "With --scenario, by the verdict of the run:\n" + sextant::reports::verdict_status_table();
}

constexpr const char* replay_option = "--replay";
constexpr const char* scenario_option = "--scenario";
constexpr const char* group = "Virtual time";

/// The options of a run in virtual time: the first makes one, the others need it.
std::vector<sextant::Option> virtual_time_options(Options& options) {
  constexpr const char* virtual_time = "--virtual-time";
  const auto part = [](const char* name, sextant::Option::Value value, const char* what) {
    return sextant::Option{.name = name, .value = value, .what = what, .group = group, .needs = virtual_time};
  };
  sextant::ecu::VirtualRunOptions& run = options.virtual_run;
  sextant::ecu::ScenarioRunOptions& scenario = options.scenario_run;
  return {{.name = virtual_time,
           .value = &options.log,
           .what = "run in virtual time, with commands from this recording, or from --profile",
           .type_name = "LOG",
           .excludes = {replay_option},
           .given = &options.virtual_time,
           .may_be_empty = true},
          part("--profile", &run.profile, "torque profile for a vehicle to play, .csv"),
          {.name = "--scenario",
           .value = &scenario.scenario,
           .what = "scenario for a vehicle to play, evaluated by its [expect]; drive and plant are those of "
                   "the configuration file, or of the scenario where no file is given",
           .type_name = "SCENARIO.toml",
           .group = group,
           .needs = virtual_time,
           .excludes = {"--profile"}},
          {.name = "--lockstep",
           .value = &run.lockstep,
           .what = "frames from the standard input, those of the drive to the standard output, as candump -l "
                   "writes them; a line (SECONDS) asks to go on until then (sextant.Vcu)",
           .group = group,
           .needs = virtual_time,
           .excludes = {"--profile", scenario_option}},
          {.name = "--log-interface",
           .value = &run.log_interface,
           .what = "the interface of a recording that has several",
           .group = group,
           .needs = virtual_time,
           .excludes = {scenario_option}},
          part("--frames-out", &run.frames_out, "record the frames of the bus, as candump -l"),
          {.name = "--set-at",
           .value = &run.set_at,
           .what = "set a key of the running drives at this time [s], or of one: drive[ID].KEY=VALUE",
           .type_name = "TIME:KEY=VALUE",
           .group = group,
           .needs = virtual_time,
           .excludes = {scenario_option}},
          part("--bus-seed", &run.bus_seed, "let the bus misbehave at random, by this seed")};
}

/// The options of a scenario's result.
std::vector<sextant::Option> scenario_options(sextant::ecu::ScenarioRunOptions& scenario) {
  std::vector<sextant::Option> options = sextant::reports::report_options(scenario.reports, scenario_option);
  options.push_back({.name = "--out",
                     .value = &scenario.out,
                     .what = "directory for the trace and the summary of the scenario",
                     .needs = scenario_option});
  options.push_back({.name = "--no-trace",
                     .value = &scenario.no_trace,
                     .what = "write the summary only",
                     .needs = "--out"});
  for (sextant::Option& option : options) option.group = group;
  return options;
}

/// Help and options must outlive it.
sextant::CommandLine command_line(const std::string& help, Options& options) {
  sextant::CommandLine line{
      options.program.c_str(),
      "Sextant: the live drive. Takes torque commands over CAN, publishes telemetry over DDS.",
      help.c_str(),
      {{.name = replay_option,
        .value = &options.replay,
        .what = "run such a recording as --record-cycles makes through the drive again and compare the gate "
                "patterns, with its configuration and --set",
        .type_name = "FILE"}}};
  for (sextant::Option& option : virtual_time_options(options)) line.options.push_back(std::move(option));
  for (sextant::Option& option : scenario_options(options.scenario_run))
    line.options.push_back(std::move(option));
  for (sextant::Option& option :
       sextant::live_options(options.live, "end after this time, with --virtual-time of virtual time [s]")) {
    if (std::string_view{option.name} != "--set") option.excludes.push_back(replay_option);
    if (std::string_view{option.name} == "--fault-socket") option.excludes.push_back("--virtual-time");
    if (std::string_view{option.name} == "--duration" || std::string_view{option.name} == "--print-config")
      option.excludes.push_back(scenario_option);
    line.options.push_back(std::move(option));
  }
  line.options.push_back({.name = "--can",
                          .value = &options.can,
                          .what = "CAN bus: socketcan:<interface> or udp_multicast:<group>:<port>",
                          .excludes = {replay_option, scenario_option}});
  line.options.push_back(
      {.name = "--timing-out",
       .value = &options.timing_out,
       .what = "write the histograms and overruns of the control thread, .json; not in virtual time",
       .excludes = {"--virtual-time", replay_option}});
  line.options.push_back({.name = "--telemetry-out",
                          .value = &options.virtual_run.telemetry_out,
                          .what = "record telemetry, .csv or .h5; with --virtual-time or --replay, live "
                                  "scripts/record does it"});
  line.options.push_back({.name = "--record-cycles",
                          .value = &options.virtual_run.record_cycles,
                          .what = "record what enters and leaves the drive in every control period, .h5",
                          .excludes = {replay_option, "--set-at"}});
  line.options.push_back({.name = "--set-socket",
                          .value = &options.set_socket,
                          .what = "take parameters on this local socket while the drive runs (scripts/set)",
                          .type_name = "FILE",
                          .excludes = {"--virtual-time", replay_option, "--record-cycles"}});
  return line;
}

/// Returns on a signal or at the end of the duration.
void wait_for_end(const sigset_t& signals, std::optional<double> duration_s) {
  if (!duration_s) {
    while (sigwaitinfo(&signals, nullptr) < 0) {
    }
    return;
  }
  // After a stop and SIGCONT sigtimedwait returns early, without one of these signals.
  const std::int64_t end_ns = sextant::now_ns() + std::int64_t(*duration_s * 1e9);
  for (std::int64_t left_ns = end_ns - sextant::now_ns(); left_ns > 0; left_ns = end_ns - sextant::now_ns()) {
    const timespec limit{left_ns / sextant::ns_per_s, left_ns % sextant::ns_per_s};
    if (sigtimedwait(&signals, nullptr, &limit) > 0) return;
  }
}

/// Exit status of a run in virtual time or of a replay; its reason, where there is one, goes to stderr.
template <class Run>
int status_of(const std::string& program, const Run& run) {
  if (const std::string reason = run.reason(); !reason.empty())
    std::fprintf(stderr, "%s: %s\n", program.c_str(), reason.c_str());
  return sextant::exit_status(run.verdict());
}

/// The configuration of the command line with more overrides behind its own.
sextant::DrivesConfig configured(const Options& options, const std::vector<std::string>& more = {}) {
  sextant::DrivesConfig config =
      sextant::load_drives_config(options.live.config, options.live.overrides_with(more), options.own);
  for (sextant::EcuConfig& drive : config.drives) {
    if (options.can) drive.can.bus = *options.can;
  }
  return config;
}

/// The configured drives in virtual time.
int run_virtual(const sextant::DrivesConfig& config, const Options& options) {
  for (const sextant::EcuConfig& drive : config.drives) sextant::ecu::require_waiting_plant(drive);
  sextant::ecu::VirtualRunOptions wanted = options.virtual_run;
  if (!options.log.empty()) wanted.log = options.log.front();
  wanted.duration_s = options.live.duration_s;
  wanted.load = [&options](const std::vector<std::string>& more) { return configured(options, more); };
  std::deque<sextant::ecu::PowerStage> stages;
  std::vector<sextant::DriveIo<double>*> ends;
  ends.reserve(config.drives.size());
  for (const sextant::EcuConfig& drive : config.drives) ends.push_back(&stages.emplace_back(drive).io());
  const auto problem = [&stages] {
    for (const sextant::ecu::PowerStage& stage : stages) {
      if (std::string found = stage.problem(); !found.empty()) return found;
    }
    return std::string{};
  };
  sextant::ecu::VirtualRun run{config, wanted, ends, problem};
  run.run();
  run.print_report(stdout);
  if (const std::string found = problem(); !found.empty())
    return sextant::status_after(options.program.c_str(), found);
  return status_of(options.program, run);
}

/// A scenario in virtual time.
int run_scenario(const Options& options) {
  sextant::ecu::ScenarioRunOptions wanted = options.scenario_run;
  if (options.live.is_config_given) wanted.config = options.live.config;
  wanted.overrides = options.live.overrides;
  wanted.run = options.virtual_run;
  if (!options.log.empty()) wanted.run.log = options.log.front();
  wanted.own = options.own;
  return sextant::ecu::run_scenario(options.program, wanted);
}

/// A recording through the drive again.
int run_replay(const Options& options) {
  sextant::ecu::CycleReplay replay{options.replay, options.live.overrides, options.own,
                                   options.virtual_run.telemetry_out};
  replay.run();
  replay.print_report(stdout);
  return status_of(options.program, replay);
}

/// Throws where the plant is not the simulated one of this process, which takes faults.
void require_simulated_plants(const sextant::DrivesConfig& config) {
  for (const sextant::EcuConfig& drive : config.drives) {
    if (drive.power_stage_kind() == sextant::PowerStageKind::simulated) continue;
    throw std::runtime_error{
        drive.power_stage_kind() == sextant::PowerStageKind::own
            ? "--fault-socket needs the simulated plant: leave it out with power_stage = \"" +
                  drive.power_stage + "\""
            : "--fault-socket: the plant is in another process; give the option to its sextant-plant"};
  }
}

int run(const Options& options) {
  if (!options.replay.empty()) return run_replay(options);
  if (!options.scenario_run.scenario.empty()) return run_scenario(options);
  const sextant::DrivesConfig config = configured(options);
  if (options.live.print_config) {
    std::fputs(sextant::print_config(config).c_str(), stdout);
    return sextant::ExitStatus::done;
  }
  for (const sextant::EcuConfig& drive : config.drives) {
    if (const std::string beyond = sextant::ecu::beyond_contract(drive.drive); !beyond.empty())
      spdlog::warn("CAN: {}", beyond);
  }
  if (options.virtual_time) return run_virtual(config, options);
  if (!options.virtual_run.telemetry_out.empty()) {
    throw std::runtime_error(
        "--telemetry-out needs --virtual-time or --replay; scripts/record records a live drive");
  }
  if (!options.live.fault_socket.empty()) require_simulated_plants(config);
  // Blocked before any thread starts, so that only wait_for_end gets them.
  const sigset_t signals = sextant::block_leave_signals();
  for (const sextant::EcuConfig& drive : config.drives) sextant::set_up_process(drive.realtime);
  sextant::ecu::Ecu ecu{
      config,
      {.record_cycles = options.virtual_run.record_cycles,
       .fault_socket = options.live.fault_socket,
       .set_socket = options.set_socket},
      [&options](const std::vector<std::string>& more) { return configured(options, more); }};
  ecu.start();
  wait_for_end(signals, options.live.duration_s);
  ecu.stop();
  // The file before the report: stdout may be closed.
  if (!options.timing_out.empty()) ecu.write_timing(options.timing_out);
  ecu.print_report(stdout);
  return sextant::status_after(options.program.c_str(), ecu.problem());
}

}  // namespace

int sextant::ecu_program(int argc, char** argv, const EcuExtensions& own) {
  Options options{.program = program_name(argc, argv, "sextant-ecu"), .own = own};
  start_log(options.program);
  const std::string help = fmt::format(examples, options.program) + status_table();
  CommandLine line = command_line(help, options);
  line.refused = [&options](const std::string& why) {
    ecu::report_not_started(options.program, options.scenario_run, why);
  };
  if (const std::optional<int> status = line.parse(argc, argv)) return *status;
  return run_program(options.program.c_str(), [&] { return run(options); });
}
