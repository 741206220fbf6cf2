#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace sextant {

/// One option of a program, or one positional argument (a name without dashes).
struct Option {
  /// Where the value goes; must outlive the parsing. A bool is a flag. A vector of positional arguments takes
  /// all of them, one of an option takes one value each time the option is given.
  using Value = std::variant<bool*, int*, std::int64_t*, std::uint32_t*, std::size_t*, double*, std::string*,
                             std::filesystem::path*, std::optional<double>*, std::optional<std::uint64_t>*,
                             std::optional<std::string>*, std::vector<std::string>*>;
  const char* name;
  Value value;
  const char* what;                     ///< for the help
  const char* type_name{nullptr};       ///< for the help; nullptr: that of the value
  const char* group{nullptr};           ///< heading in the help; nullptr: Options
  const char* needs{nullptr};           ///< an option before this one that must be given too
  std::vector<const char*> excludes{};  ///< options before this one that must not be given too
  bool* given{nullptr};                 ///< set to whether the option was given
  bool required{false};
  bool may_be_empty{false};                             ///< a vector of an option: none or one value
  std::vector<std::string> choices{};                   ///< the values allowed; empty: any
  double least{std::numeric_limits<double>::lowest()};  ///< of a number
  double most{std::numeric_limits<double>::max()};      ///< of a number
};

/// The command line of a program. It is the one user of CLI11, whose header costs seconds in every source.
struct CommandLine {
  const char* program;
  const char* description;  ///< one sentence, at the top of the help
  const char* notes;        ///< at the end of the help: examples
  std::vector<Option> options;
  /// Called with what is wrong after a mistake; options that contradict each other have their values then.
  std::function<void(const std::string& why)> refused{};

  /// Fills in the values. Empty when the program may go on, else its exit status: `done` after help or
  /// version, `refused` after a mistake, of which one sentence has been printed.
  [[nodiscard]] std::optional<int> parse(int argc, char** argv) const;
};

}  // namespace sextant
