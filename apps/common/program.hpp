#pragma once

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "common/exit_status.hpp"

namespace sextant {

/// The file name of the program that runs, for its messages; `otherwise` where it is not known.
[[nodiscard]] inline std::string program_name(int argc, char** argv, const char* otherwise) {
  return argc > 0 ? std::filesystem::path{argv[0]}.filename().string() : otherwise;
}

/// The status of a program that has run: `failed` where a problem ended it, whose sentence goes to stderr.
[[nodiscard]] inline int status_after(const char* name, const std::string& problem) {
  if (problem.empty()) return ExitStatus::done;
  std::fprintf(stderr, "%s: %s\n", name, problem.c_str());
  return ExitStatus::failed;
}

/// The status of a program at its end: `failed` instead of `done` where its standard output could not be
/// written whole, whose sentence goes to stderr. An output that was closed before the start is none.
[[nodiscard]] inline int after_output(const char* name, int status) {
  errno = 0;
  const bool has_failed = std::fflush(stdout) != 0 || std::ferror(stdout) != 0;
  const int reason = errno;  // none where an earlier write failed
  if (!has_failed || fcntl(STDOUT_FILENO, F_GETFD) == -1) return status;
  const int failed = status_after(
      name, "the standard output cannot be written: " +
                (reason != 0 ? std::generic_category().message(reason) : "its file system may be full"));
  return status == ExitStatus::done ? failed : status;
}

/// Runs a program to its exit status. An exception becomes a sentence on stderr and the status `refused`; a
/// file beyond the limit of its size is a write that fails, not the end of the program.
template <class Run>
int run_program(const char* name, const Run& run) {
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return after_output(name, run());
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s: %s\n", name, problem.what());
    return ExitStatus::refused;
  }
}

}  // namespace sextant
