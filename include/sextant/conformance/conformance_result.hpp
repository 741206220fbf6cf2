#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace sextant {

/// What is wrong with what was checked: the first violation of each rule, a sentence each, which begins with
/// the rule's name and a colon. Empty: it conforms.
struct ConformanceResult {
  std::uint64_t seed{};  ///< of the inputs; 0 where none is at random
  std::vector<std::string> violations{};

  [[nodiscard]] bool passed() const noexcept { return violations.empty(); }

  /// Whether a violation of this rule, named with its colon, is among them.
  [[nodiscard]] bool has(const std::string& rule) const {
    for (const std::string& known : violations) {
      if (known.starts_with(rule)) return true;
    }
    return false;
  }
};

/// Prints the result, with its seed where there is one; returns the exit status of a program, 0 when it
/// conforms.
inline int report(const char* name, const ConformanceResult& result, std::FILE* out = stdout) {
  for (const std::string& violation : result.violations)
    std::fprintf(out, "%s: %s\n", name, violation.c_str());
  std::fprintf(out, "%s: %s", name, result.passed() ? "conforms" : "does not conform");
  if (result.seed != 0) std::fprintf(out, ", seed %llu", static_cast<unsigned long long>(result.seed));
  std::fprintf(out, "\n");
  return result.passed() ? 0 : 1;
}

}  // namespace sextant
