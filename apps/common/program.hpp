#pragma once

#include <cstdio>
#include <exception>

namespace sextant {

/// Runs a program to its exit status. An exception becomes a sentence on stderr and the status `failure`.
template <class Run>
int run_program(const char* name, int failure, const Run& run) {
  try {
    return run();
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s: %s\n", name, problem.what());
    return failure;
  }
}

}  // namespace sextant
