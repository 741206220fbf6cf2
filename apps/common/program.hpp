#pragma once

#include <csignal>
#include <cstdio>
#include <exception>

namespace sextant {

/// Runs a program to its exit status. An exception becomes a sentence on stderr and the status `failure`; a
/// file beyond the limit of its size is a write that fails, not the end of the program.
template <class Run>
int run_program(const char* name, int failure, const Run& run) {
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return run();
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s: %s\n", name, problem.what());
    return failure;
  }
}

}  // namespace sextant
