#include "reports/report_options.hpp"

#include <cstdio>
#include <stdexcept>

#include <fmt/format.h>

#include "reports/run_reports.hpp"

namespace sextant::reports {

std::vector<Option> report_options(ReportOptions& options, const char* needs) {
  return {{.name = "--require-expectations",
           .value = &options.require_expectations,
           .what = "a scenario that expects nothing is a failure",
           .needs = needs},
          {.name = "--junit",
           .value = &options.junit,
           .what = "write a JUnit file: a test suite for each scenario",
           .type_name = "FILE",
           .needs = needs},
          {.name = "--summary-markdown",
           .value = &options.summary_markdown,
           .what = "append a Markdown table for each scenario",
           .type_name = "FILE",
           .needs = needs}};
}

void report_not_started(const std::string& program, const ReportOptions& options,
                        const std::vector<std::string>& scenarios, const std::string& why) {
  const std::vector<std::string> names = scenarios.empty() ? std::vector{program} : scenarios;
  try {
    RunReports reports{options, names, program};
    for (const std::string& name : names) reports.add_error(name, "did not run: " + why);
  } catch (const std::runtime_error& problem) {
    fmt::print(stderr, "{}: {}\n", program, problem.what());
  }
}

}  // namespace sextant::reports
