#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/command_line.hpp"

namespace sextant::reports {

/// The options of every program that runs scenarios.
struct ReportOptions {
  std::filesystem::path junit{};             ///< empty: none
  std::filesystem::path summary_markdown{};  ///< empty: none
  bool require_expectations{false};
};

/// The options that fill them in. needs: an option that must be given with them; null: none.
[[nodiscard]] std::vector<Option> report_options(ReportOptions& options, const char* needs = nullptr);

/// Reports of a command that did not start, in the place of those of an earlier one: `why` is an error of
/// each scenario, or of the program where it has none. Where the reports cannot be written, a line of the
/// program says so.
void report_not_started(const std::string& program, const ReportOptions& options,
                        const std::vector<std::string>& scenarios, const std::string& why);

}  // namespace sextant::reports
