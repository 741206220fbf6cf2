#pragma once

#include <cstdio>
#include <exception>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace sextant {

/// The common part of every program's command line: help that ends in examples, version, and one sentence for
/// each mistake.
inline void describe_program(CLI::App& app, const std::string& name, const char* examples) {
  app.footer(examples);
  app.set_version_flag("--version", SEXTANT_VERSION);
  app.failure_message([name](const CLI::App*, const CLI::Error& error) {
    return name + ": " + error.what() + "; " + name + " --help lists the options\n";
  });
}

/// Reads the command line. Empty when the program may go on, else its exit status: 0 after help or version, 2
/// after a mistake, of which one sentence and the usage have been printed.
inline std::optional<int> parse_command_line(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
}

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
