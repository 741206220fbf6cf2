#pragma once

#include <string>
#include <string_view>

namespace sextant {

/// Exit statuses of every program. `verdict_catalogue` has those of a run that has a verdict, which contains
/// `done` and `failed`.
struct ExitStatus {
  static constexpr int done{0};     ///< it ran to its end
  static constexpr int failed{1};   ///< it ran, and a problem ended it
  static constexpr int refused{2};  ///< it has not run
};

/// A line of the table of exit statuses in the help of a program.
[[nodiscard]] inline std::string exit_status_line(int status, std::string_view word,
                                                  std::string_view meaning) {
  const std::string number = std::to_string(status);
  std::string line(number.size() < 5 ? 5 - number.size() : 0, ' ');
  line.append(number).append("  ").append(word).append(word.size() < 16 ? 16 - word.size() : 0, ' ');
  return line.append("  ").append(meaning).append("\n");
}

/// The line of `ExitStatus::refused`, which stands in every program's table.
[[nodiscard]] inline std::string refused_line() {
  return exit_status_line(ExitStatus::refused, "refused",
                          "it has not run: the command, a file or a key is wrong, or the machine lacks what "
                          "it needs");
}

/// The table of a program that has no verdict.
[[nodiscard]] inline std::string exit_status_table() {
  return "Exit status:\n" + exit_status_line(ExitStatus::done, "done", "it ran to its end") +
         exit_status_line(ExitStatus::failed, "failed", "a problem ended it") + refused_line();
}

}  // namespace sextant
