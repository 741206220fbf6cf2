#pragma once

#include <exception>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace sextant {

/// The lines of a request on a local socket, without the empty ones.
[[nodiscard]] inline std::vector<std::string> request_lines(const std::string& request) {
  std::vector<std::string> all;
  std::istringstream lines{request};
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) all.push_back(line);
  }
  return all;
}

/// The sentences of a problem, without the name of an option that nobody typed in a request.
[[nodiscard]] inline std::string problem_text(const std::exception& problem) {
  constexpr std::string_view option = "--set: ";
  std::string text;
  for (std::string line : request_lines(problem.what())) {
    if (line.starts_with(option)) line.erase(0, option.size());
    text += (text.empty() ? "" : "\n") + line;
  }
  return text;
}

}  // namespace sextant
