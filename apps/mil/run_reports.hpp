#pragma once

#include <filesystem>
#include <optional>

#include "mil/junit_file.hpp"
#include "sextant/sim/summary.hpp"

namespace sextant::mil {

/// The files for continuous integration that were asked for.
class RunReports {
 public:
  /// An empty path is no file. Both are tried at once: throws std::runtime_error with file and reason where
  /// one cannot be written.
  RunReports(const std::filesystem::path& junit, std::filesystem::path markdown);

  /// Adds a run to each file.
  void add(const RunSummary& summary);

 private:
  std::optional<JUnitFile> junit_;
  std::filesystem::path markdown_;
};

}  // namespace sextant::mil
