#pragma once

#include <filesystem>
#include <string>

namespace sextant::reports {

/// The directory of one run's results, `trace.h5` and `summary.json`.
class ResultDirectory {
 public:
  /// Makes the directory, or uses an existing one. The files of an earlier run are removed, with a
  /// line of `program` on standard error, so that no file of it remains beside those of the new one. Throws
  /// std::runtime_error with a sentence where the directory cannot be made, or has a file of one of these
  /// names that is no result.
  ResultDirectory(std::filesystem::path directory, const std::string& program);

  [[nodiscard]] std::filesystem::path trace() const { return directory_ / "trace.h5"; }
  [[nodiscard]] std::filesystem::path summary() const { return directory_ / "summary.json"; }

 private:
  void clear(const std::string& program) const;

  std::filesystem::path directory_;
};

}  // namespace sextant::reports
