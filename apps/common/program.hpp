#pragma once

#include <csignal>
#include <cstdio>
#include <exception>
#include <string>

#include "common/exit_status.hpp"

namespace sextant {

/// The status of a program that has run: `failed` where a problem ended it, whose sentence goes to stderr.
[[nodiscard]] inline int status_after(const char* name, const std::string& problem) {
  if (problem.empty()) return ExitStatus::done;
  std::fprintf(stderr, "%s: %s\n", name, problem.c_str());
  return ExitStatus::failed;
}

/// Runs a program to its exit status. An exception becomes a sentence on stderr and the status `refused`; a
/// file beyond the limit of its size is a write that fails, not the end of the program.
template <class Run>
int run_program(const char* name, const Run& run) {
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return run();
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s: %s\n", name, problem.what());
    return ExitStatus::refused;
  }
}

}  // namespace sextant
