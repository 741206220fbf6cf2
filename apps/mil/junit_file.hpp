#pragma once

#include <filesystem>

#include <pugixml.hpp>

#include "sextant/sim/summary.hpp"

namespace sextant::mil {

/// A JUnit file of runs: a test suite for each scenario, with a test case for the verdict, for an expected
/// fault, and for each limit. A limit that does not hold is a failure, a run that could not be evaluated
/// (tripped, interrupted, out of balance, …) an error of the verdict.
class JUnitFile {
 public:
  /// Writes a file without suites. Throws std::runtime_error with file and reason.
  explicit JUnitFile(std::filesystem::path file);

  /// Adds the suite of a run and writes the file anew. Throws std::runtime_error with file and reason.
  void add(const RunSummary& summary);

 private:
  void write();

  std::filesystem::path file_;
  pugi::xml_document document_;
  double time_s_{0};  ///< of the runs so far, in wall time [s]
};

}  // namespace sextant::mil
