#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <pugixml.hpp>

#include "sextant/run/summary.hpp"

namespace sextant::reports {

/// A JUnit file of runs: a test suite for each scenario, with a test case for the verdict, for an expected
/// fault, and for each limit. A limit that does not hold is a failure, a run that could not be evaluated
/// (tripped, interrupted, out of balance, …) an error of the verdict. The verdict of a scenario that has not
/// run is skipped.
class JUnitFile {
 public:
  /// Writes a file of the program in which no scenario has run, in place of an older one. Throws
  /// std::runtime_error with file and reason where it cannot be written, or where a file stands that is
  /// neither empty nor JUnit.
  JUnitFile(std::filesystem::path file, const std::vector<std::string>& scenarios,
            const std::string& program);

  /// The run of the next scenario: fills its suite and writes the file anew. Throws std::runtime_error with
  /// file and reason.
  void add(const RunSummary& summary);

  /// The next scenario has no summary, for this reason. Throws as `add`.
  void add_error(const std::string& reason);

 private:
  pugi::xml_node next();
  void write();

  std::filesystem::path file_;
  pugi::xml_document document_;
  pugi::xml_node next_;  ///< suite of the first scenario that has not run
  double time_s_{0};     ///< of the runs so far, in wall time [s]
};

}  // namespace sextant::reports
