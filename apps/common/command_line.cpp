#include "common/command_line.hpp"

#include <cmath>
#include <type_traits>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "common/exit_status.hpp"
#include "common/program.hpp"

namespace sextant {
namespace {

template <class T>
CLI::Option* add_value(CLI::App& app, const Option& option, T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    return app.add_flag(option.name, value, option.what);
  } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
    CLI::Option* const added = app.add_option(option.name, value, option.what);
    if (option.may_be_empty) return added->expected(0, 1);
    return option.name[0] == '-' ? added->take_all()->expected(1) : added;
  } else {
    return app.add_option(option.name, value, option.what);
  }
}

template <class T>
constexpr bool is_whole = std::is_integral_v<T>;
template <class T>
constexpr bool is_whole<std::optional<T>> = is_whole<T>;

template <class T>
constexpr bool has_default = std::is_same_v<T, std::string> || std::is_same_v<T, std::filesystem::path>;

template <class T>
void show_default(CLI::Option& added, const T& value) {
  if constexpr (has_default<T>) {
    if (!value.empty()) added.capture_default_str();
  }
}

/// Of a number, which is a whole one where `is_whole`.
CLI::Validator range(double least, double most, bool is_whole) {
  const char* const number = is_whole ? "a whole number" : "a number";
  const auto check = [least, most, is_whole, number](const std::string& text) -> std::string {
    double value = 0;
    const bool is_number = CLI::detail::lexical_cast(text, value);
    const bool is_right = is_number && (!is_whole || std::floor(value) == value);
    if (is_right && value >= least && value <= most) return {};
    const std::string end =
        most < std::numeric_limits<double>::max() ? fmt::format(" to {:g}", most) : std::string{};
    return fmt::format("expected {} from {:g}{}, got {}", number, least, end, text);
  };
  return CLI::Validator{check, fmt::format("{} in [{:g} - {:g}]", is_whole ? "INT" : "FLOAT", least, most)};
}

/// The names of the values, the help and the checks.
void refine(CLI::App& app, CLI::Option& added, const Option& option, bool is_whole) {
  if (option.type_name != nullptr) added.type_name(option.type_name);
  if (option.group != nullptr) added.group(option.group);
  if (option.needs != nullptr) added.needs(app.get_option(option.needs));
  for (const char* other : option.excludes) added.excludes(app.get_option(other));
  if (option.required) added.required();
  if (!option.choices.empty()) added.check(CLI::IsMember(option.choices));
  const bool bounded = option.least > std::numeric_limits<double>::lowest() ||
                       option.most < std::numeric_limits<double>::max();
  if (bounded) added.check(range(option.least, option.most, is_whole));
}

void add(CLI::App& app, const Option& option) {
  std::visit(
      [&](auto* value) {
        CLI::Option& added = *add_value(app, option, *value);
        show_default(added, *value);
        refine(app, added, option, is_whole<std::remove_pointer_t<decltype(value)>>);
      },
      option.value);
}

}  // namespace

std::optional<int> CommandLine::parse(int argc, char** argv) const {
  CLI::App app{description};
  app.footer(notes);
  app.set_version_flag("--version", SEXTANT_VERSION);
  app.failure_message([this](const CLI::App*, const CLI::Error& error) {
    const std::string name{program};
    return name + ": " + error.what() + "; " + name + " --help lists the options\n";
  });
  for (const Option& option : options) add(app, option);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (app.exit(error) == 0) return after_output(program, ExitStatus::done);
    if (refused) refused(error.what());
    return ExitStatus::refused;
  }
  for (const Option& option : options) {
    if (option.given != nullptr) *option.given = app.count(option.name) > 0;
  }
  return std::nullopt;
}

}  // namespace sextant
