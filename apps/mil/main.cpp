#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "common/program.hpp"
#include "mil/progress_bar.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/config/make_controller.hpp"
#include "sextant/sim/mil_runner.hpp"
#include "sextant/sim/simulated_power_stage.hpp"
#include "sextant/sim/summary.hpp"
#include "sextant/sim/trace_recorder.hpp"

namespace {

constexpr const char* program_name = "sextant-mil";

struct Options {
  std::vector<std::string> scenarios{};
  std::filesystem::path out{"out"};
  std::vector<std::string> overrides{};
  std::optional<std::string> integrator{};
  bool print_config{false};
  bool no_trace{false};
};

constexpr const char* examples = R"(Examples:
  sextant-mil configs/scenarios/constant_torque.toml
  sextant-mil configs/scenarios/*.toml --integrator fixed
  sextant-mil configs/scenarios/reversal.toml --set control.torque_band_upper_nm=0.5 --out out/half_band
  sextant-mil configs/scenarios/reversal.toml --print-config
Writes DIR/<scenario>/trace.h5 and DIR/<scenario>/summary.json (straight into DIR for one scenario) and
exits with 0 only if every [expect] holds.)";

void describe(CLI::App& app, Options& options) {
  sextant::describe_program(app, program_name, examples);
  app.add_option("scenarios", options.scenarios, "scenario files")->required()->type_name("SCENARIO.toml");
  app.add_option("--out", options.out, "directory for traces and summaries")->capture_default_str();
  app.add_option("--set", options.overrides, "key=value, overrides the files")->take_all()->expected(1);
  app.add_option("--integrator", options.integrator, "how the plant is integrated")
      ->check(CLI::IsMember({"cvode", "fixed", "exact", "erk"}));
  app.add_flag("--no-trace", options.no_trace, "write the summary only");
  app.add_flag("--print-config", options.print_config, "print the configuration in force and leave");
}

void make_directory(const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (!error) return;
  throw std::runtime_error("the directory " + directory.string() + " cannot be made: " + error.message() +
                           "; --out names another");
}

sextant::MilResult run_sampled(const sextant::ScenarioConfig& config, sextant::TraceRecorder* trace,
                               const sextant::MilRunner::Progress& progress) {
  using namespace sextant;
  SimulatedPowerStage power_stage{config.drive.plant, config.scenario.load};
  const auto controller = make_controller(config.drive);
  Drive<double> drive{config.drive.drive, *controller};
  MilRunner runner{drive, power_stage.io(), config.drive.drive.period_ns};
  return runner.run(config.scenario, trace, progress);
}

sextant::MilResult run_scenario(const sextant::ScenarioConfig& config, sextant::TraceRecorder* trace,
                                const sextant::MilRunner::Progress& progress) {
  if (config.mode == sextant::ScenarioMode::sampled) return run_sampled(config, trace, progress);
  return sextant::EventExactRunner{config.event_exact_runner()}.run(config.scenario, trace, progress);
}

/// What the trace says of its run; an event-exact one has no control period.
sextant::TraceOrigin origin(const sextant::ScenarioConfig& config) {
  const bool sampled = config.mode == sextant::ScenarioMode::sampled;
  return {config.scenario.name,
          sampled ? std::optional<std::int64_t>{config.drive.drive.period_ns} : std::nullopt};
}

/// One scenario, from its file to its summary; false when it did not pass.
bool report_scenario(const sextant::ScenarioConfig& config, const std::filesystem::path& directory,
                     bool with_trace) {
  using namespace sextant;
  const Scenario& scenario = config.scenario;
  make_directory(directory);
  std::optional<TraceRecorder> trace;
  if (with_trace) trace.emplace(directory / "trace.h5", scenario.trace, origin(config));

  mil::ProgressBar bar{scenario.name, stderr};
  const MilResult result =
      run_scenario(config, trace ? &*trace : nullptr, [&bar](double fraction) { return bar.show(fraction); });
  bar.finish();
  if (trace) trace->close();

  const RunSummary summary{scenario.name, result.metrics, evaluate(scenario.expectations, result.metrics)};
  write_summary(summary, directory / "summary.json");
  print_summary(summary, stdout);
  if (!result.events_ended) {
    std::fprintf(
        stderr,
        "sextant-mil: %s: the events do not end at %.6f s; a longer event_exact.minimum_dwell_ns bounds "
        "them, event_exact.max_events allows more\n",
        scenario.name.c_str(), result.metrics[Metric::simulated]);
  } else if (!result.plant_healthy) {
    std::fprintf(stderr, "sextant-mil: %s: the integrator of the plant failed; the run ends there\n",
                 scenario.name.c_str());
  }
  if (result.faults.any()) {
    std::fprintf(stderr,
                 "sextant-mil: %s: the drive tripped with %s at %.6f s; see [protection] and [gate]\n",
                 scenario.name.c_str(), to_string(result.first_fault), double(result.fault_ns) * 1e-9);
  }
  const bool written = !trace || trace->error().empty();
  return summary.passed() && result.plant_healthy && !result.faults.any() && written;
}

/// Results are kept under the scenarios' names: each needs one of its own, and one that stays in --out.
void check_names(const std::vector<std::string>& files, const std::vector<sextant::ScenarioConfig>& configs) {
  for (std::size_t i = 0; i < configs.size(); ++i) {
    const std::string& name = configs[i].scenario.name;
    if (name == "." || name == ".." || name.find('/') != std::string::npos) {
      throw std::runtime_error(files[i] + ": the name \"" + name +
                               "\" cannot be that of a directory: choose one without \"/\"");
    }
    for (std::size_t before = 0; before < i; ++before) {
      if (configs[before].scenario.name != name) continue;
      throw std::runtime_error(files[i] + ": the name \"" + name + "\" is taken by " + files[before] +
                               ", whose results would be overwritten: choose another");
    }
  }
}

int run(Options options) {
  if (options.integrator) options.overrides.push_back("plant.integrator=" + *options.integrator);
  // All files are read before anything runs: a mistake in the last one must not cost the first its time.
  std::vector<sextant::ScenarioConfig> configs;
  configs.reserve(options.scenarios.size());
  for (const std::string& file : options.scenarios) {
    configs.push_back(sextant::load_scenario_config(file, options.overrides));
  }
  if (!options.print_config) check_names(options.scenarios, configs);
  bool passed = true;
  for (const sextant::ScenarioConfig& config : configs) {
    if (options.print_config) {
      std::fputs(sextant::print_config(config).c_str(), stdout);
      continue;
    }
    const bool alone = configs.size() == 1;
    passed &=
        report_scenario(config, alone ? options.out : options.out / config.scenario.name, !options.no_trace);
  }
  return passed ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Sextant: runs scenarios of the drive with its model in the loop."};
  Options options;
  describe(app, options);
  CLI11_PARSE(app, argc, argv);
  return sextant::run_program(program_name, 2, [&] { return run(options); });
}
