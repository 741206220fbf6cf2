#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "ecu/virtual_time/virtual_run.hpp"
#include "reports/report_options.hpp"
#include "sextant/config/ecu_extensions.hpp"

namespace sextant::ecu {

/// The command line's options of a scenario in virtual time.
struct ScenarioRunOptions {
  std::string scenario{};                ///< file
  std::string config{};                  ///< of drive and plant; empty: those of the scenario
  std::vector<std::string> overrides{};  ///< of the configuration, without one of the scenario
  EcuExtensions own{};                   ///< that the program brings
  std::filesystem::path out{};           ///< directory of its result; empty: none is kept
  bool no_trace{false};
  reports::ReportOptions reports{};
  VirtualRunOptions run{};  ///< without profile and duration; one with a recording is refused
};

/// Reports of a scenario, if there is one, that has not run, and why.
void report_not_started(const std::string& program, const ScenarioRunOptions& options,
                        const std::string& why);

/// Plays a scenario to the live drive in virtual time. Where the plant is in this process, the run is
/// evaluated by [expect] and reported; a plant in lockstep does so itself. Returns the exit status of the
/// verdict; a mistake is also an error in the reports. Throws std::runtime_error with one sentence.
[[nodiscard]] int run_scenario(const std::string& program, const ScenarioRunOptions& options);

}  // namespace sextant::ecu
