#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace sextant {

/// One thing that is wrong with a configuration, and where.
struct ConfigProblem {
  std::string file{};     ///< as given to the reader, or `--set`
  int line{0};            ///< from 1; 0 where no line applies
  std::string key{};      ///< dotted path; empty for the file as a whole
  std::string message{};  ///< what was expected and what was found

  /// `file:line: key: message`.
  [[nodiscard]] std::string to_string() const {
    std::string text = file;
    if (line > 0) text += ":" + std::to_string(line);
    if (!key.empty()) text += ": " + key;
    return text + ": " + message;
  }
};

/// A configuration was refused. what() has one line for each problem.
class ConfigError : public std::runtime_error {
 public:
  explicit ConfigError(std::vector<ConfigProblem> problems)
      : std::runtime_error{join(problems)}, problems_{std::move(problems)} {}

  [[nodiscard]] const std::vector<ConfigProblem>& problems() const noexcept { return problems_; }

 private:
  static std::string join(const std::vector<ConfigProblem>& problems) {
    std::string text;
    for (const ConfigProblem& p : problems) text += (text.empty() ? "" : "\n") + p.to_string();
    return text;
  }

  std::vector<ConfigProblem> problems_;
};

}  // namespace sextant
