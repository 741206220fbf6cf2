#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "reports/junit_file.hpp"
#include "reports/report_options.hpp"
#include "sextant/run/summary.hpp"

namespace sextant::reports {

/// The files for continuous integration that were asked for.
class RunReports {
 public:
  /// An empty path is no file; the directory of one is made. Both are tried at once: throws
  /// std::runtime_error with file and reason where one cannot be written, and where both are the same file.
  RunReports(const ReportOptions& files, const std::vector<std::string>& scenarios,
             const std::string& program);

  /// Adds the run of the next scenario to each file.
  void add(const RunSummary& summary);

  /// Adds to each file why the next scenario, of this name, has no summary.
  void add_error(const std::string& scenario, const std::string& reason);

 private:
  std::optional<JUnitFile> junit_;
  std::filesystem::path markdown_;
};

}  // namespace sextant::reports
