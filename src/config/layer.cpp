#include "layer.hpp"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "number_text.hpp"
#include "own_names.hpp"
#include "sextant/files/text_lines.hpp"

namespace sextant {
namespace {

[[noreturn]] void refuse(std::string file, int line, std::string key, std::string message) {
  throw ConfigError{{{std::move(file), line, std::move(key), std::move(message)}}};
}

std::string file_text(const std::string& file) {
  if (std::string reason = why_unreadable(file); !reason.empty()) refuse(file, 0, "", std::move(reason));
  std::ifstream stream{file, std::ios::binary};
  if (!stream) refuse(file, 0, "", "cannot be read: " + std::generic_category().message(errno));
  std::ostringstream text;
  text << stream.rdbuf();
  return std::move(text).str();
}

/// A value that needs no quotes after --set.
bool is_bare_word(std::string_view value) {
  return value.find_first_not_of(std::string{bare_key} + "./:+~") == std::string_view::npos;
}

/// Refuses a file that is not there, at the place that names it.
void require_file(const std::string& file, const std::string& kind, ConfigProblem place) {
  std::error_code error;
  if (std::filesystem::exists(file, error)) return;
  place.message = "the " + kind + " file " + file + " does not exist";
  throw ConfigError{{std::move(place)}};
}

/// Where a layer names the file of a section, if it does; the name is taken out.
std::optional<std::string> take_section_file(Layer& layer, const std::string& section, int& line) {
  const std::size_t dot = section.rfind('.');
  const bool is_inside = dot != std::string::npos;
  toml::table* const holder =
      is_inside ? layer.table.at_path(section.substr(0, dot)).as_table() : &layer.table;
  const std::string name = is_inside ? section.substr(dot + 1) : section;
  toml::node* given = holder == nullptr ? nullptr : holder->get(name);
  if (given == nullptr) return std::nullopt;
  toml::node* node = given;
  std::string key = section;
  if (toml::table* table = given->as_table()) {
    node = table->get("file");
    key += ".file";
    if (node == nullptr) return std::nullopt;
  }
  auto path = node->value<std::string>();
  const ConfigProblem place =
      layer.problem(node, key, "expected the path of a " + section + " file, got " + shown(*node));
  if (!path || path->empty()) throw ConfigError{{place}};
  line = place.line;
  if (toml::table* table = given->as_table()) {
    table->erase("file");
  } else {
    holder->erase(name);
  }
  return layer.resolved(*path);
}

}  // namespace

std::string Layer::local_path(std::string_view path) const {
  if (prefix.empty()) return std::string{path};
  if (path == prefix) return {};
  const bool inside = path.starts_with(prefix + ".");
  return std::string{inside ? path.substr(prefix.size() + 1) : path};
}

std::string Layer::resolved(const std::string& path) const {
  if (is_override) return path;
  return (std::filesystem::path{file}.parent_path() / path).lexically_normal().string();
}

const toml::node* Layer::find(std::string_view path) const {
  if (!prefix.empty() && path != prefix && !path.starts_with(prefix + ".")) return nullptr;
  const std::string local = local_path(path);
  return local.empty() ? &table : table.at_path(local).node();
}

ConfigProblem Layer::problem(const toml::node* node, std::string_view path, std::string message) const {
  const int line = is_override || node == nullptr ? 0 : static_cast<int>(node->source().begin.line);
  return {file, line, local_path(path), std::move(message)};
}

Layer read_layer(const std::string& file, const std::string& prefix) {
  return text_layer(file_text(file), file, prefix);
}

Layer text_layer(const std::string& text, const std::string& file, const std::string& prefix) {
  try {
    return {file, prefix, false, toml::parse(text, file)};
  } catch (const toml::parse_error& error) {
    refuse(file, static_cast<int>(error.source().begin.line), "",
           "not valid TOML: " + std::string{error.description()});
  }
}

Layer override_layer(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::string key = text.substr(0, text.find_last_not_of(' ', equals == 0 ? 0 : equals - 1) + 1);
  if (equals == std::string::npos || equals + 1 == text.size() || key.empty() ||
      key.find_first_not_of(std::string{bare_key} + ".") != std::string::npos) {
    refuse("--set", 0, "", "expected key=value with a dotted key, got \"" + text + "\"");
  }
  const std::string value = text.substr(equals + 1);
  if (value.find_first_of("\r\n") != std::string::npos)
    refuse("--set", 0, key, "the value must be on one line");
  try {
    return {"--set", "", true, toml::parse(key + " = " + value)};
  } catch (const toml::parse_error& error) {
    if (!is_bare_word(value)) {
      refuse("--set", 0, key, "not a TOML value: " + std::string{error.description()});
    }
  }
  try {
    return {"--set", "", true, toml::parse(key + " = '" + value + "'")};
  } catch (const toml::parse_error& error) {
    refuse("--set", 0, key, "not a key: " + std::string{error.description()});
  }
}

void insert_section_layer(std::vector<Layer>& layers, const std::string& section) {
  std::optional<std::string> file;
  ConfigProblem place;
  for (Layer& layer : layers) {
    int line = 0;
    if (auto found = take_section_file(layer, section, line)) {
      file = std::move(found);
      place = {layer.file, line, section, ""};
    }
  }
  if (!file) return;
  require_file(*file, section, std::move(place));
  layers.insert(layers.begin(), read_layer(*file, section));
}

void insert_base_layers(std::vector<Layer>& layers) {
  constexpr const char* key = "base";
  constexpr std::size_t most_bases = 8;
  for (std::size_t bases = 0;; ++bases) {
    Layer& changes = layers.front();
    const toml::node* node = changes.table.get(key);
    if (node == nullptr) return;
    if (bases == most_bases) {
      throw ConfigError{{changes.problem(
          node, key,
          fmt::format("more than {} files one behind the other, or a circle of them", most_bases))}};
    }
    const auto path = node->value<std::string>();
    ConfigProblem place = changes.problem(node, key, "expected the path of a file, got " + shown(*node));
    if (!path || path->empty()) throw ConfigError{{std::move(place)}};
    const std::string file = changes.resolved(*path);
    require_file(file, key, std::move(place));
    changes.table.erase(key);
    layers.insert(layers.begin(), read_layer(file));
  }
}

std::string shown(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::date:
    case toml::node_type::time:
    case toml::node_type::date_time:
      return "a date or time";
    case toml::node_type::string:
      return "\"" + node.as_string()->get() + "\"";
    default:
      break;
  }
  std::ostringstream text;
  node.visit([&text](const auto& value) {
    if constexpr (toml::is_floating_point<decltype(value)>) {
      text << number_text(value.get());
    } else if constexpr (toml::is_value<decltype(value)>) {
      text << value;
    }
  });
  return std::move(text).str();
}

}  // namespace sextant
