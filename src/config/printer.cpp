#include "printer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "expected.hpp"
#include "number_text.hpp"

namespace sextant {
namespace {

/// TOML basic string. Control characters have no other way into it.
std::string quoted(const std::string& text) {
  constexpr std::string_view hex = "0123456789abcdef";
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') out += '\\';
    if (byte < 0x20 || byte == 0x7f) {
      out += "\\u00";
      out += hex[byte >> 4U];
      out += hex[byte & 0xfU];
    } else {
      out += c;
    }
  }
  return out + "\"";
}

/// A value as TOML, which for these is JSON too.
struct ValueText {
  std::string operator()(double x) const { return number_text(x); }
  std::string operator()(std::int64_t x) const { return std::to_string(x); }
  std::string operator()(bool x) const { return x ? "true" : "false"; }
  std::string operator()(const std::string& text) const { return quoted(text); }
  std::string operator()(const PointsMember::Point& point) const {
    return "[" + number_text(point.first) + ", " + number_text(point.second) + "]";
  }
  template <class Item>
  std::string operator()(const std::vector<Item>& items) const {
    std::string text;
    for (const Item& item : items) text += (text.empty() ? "" : ", ") + (*this)(item);
    return "[" + text + "]";
  }
};

/// The value of a key as JSON; null for an optional one that is not set.
std::string json_value(const Field& field) {
  const auto value = field.member.get();
  const double* const number = value ? std::get_if<double>(&*value) : nullptr;
  const bool is_json = value && (number == nullptr || std::isfinite(*number));
  return is_json ? std::visit(ValueText{}, *value) : "null";
}

std::string comment(const Field& field, const std::string& preset) {
  std::string text = "  # " + field.meaning;
  if (!field.unit.empty()) text += " [" + field.unit + "]";
  text += "; " + expected(field.kind);
  if (field.required) return text + "; required";
  if (field.derived) return text + "; default derived from machine and link";
  return text + "; default " + (preset.empty() ? "not set" : preset);
}

/// The heading of a table; of an item of a list where the path ends in `[k]`.
std::string heading(const std::string& path) {
  std::string name;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (path[i] == '[') i = path.find(']', i) + 1;
    if (i < path.size()) name += path[i];
  }
  return path.ends_with(']') ? "[[" + name + "]]" : "[" + name + "]";
}

/// The same with the items that its lists have now.
Schema expanded(const Schema& schema, const Schema& sizes) {
  Schema whole = schema;
  for (std::size_t i = 0; i < schema.lists.size(); ++i) schema.lists[i].expand(whole, sizes.lists[i].size());
  return whole;
}

/// True for a key of an unused table whose defaults do not hold, so that its values must not be read back.
bool is_left_out(const Schema& schema, const Field& field) {
  return std::any_of(schema.checks.begin(), schema.checks.end(), [&field](const Check& check) {
    return !check.counts(false) && field.path.starts_with(check.optional_table + ".") &&
           !check.problem().empty();
  });
}

/// What a key may hold, as further members of a JSON object.
struct JsonBounds {
  template <class Kind>
  std::string operator()(const Kind& kind) const {
    const ValueText text;
    if constexpr (requires { kind.range; })
      return ", \"least\": " + text(kind.range.min) + ", \"most\": " + text(kind.range.max);
    else if constexpr (requires { kind.names; })
      return ", \"choices\": " + text(kind.names);
    else
      return "";
  }
};

/// What a key is, as members of a JSON object.
std::string described(const Field& field) {
  return "\"key\": " + quoted(field.path) + ", \"unit\": " + quoted(field.unit) +
         ", \"meaning\": " + quoted(field.meaning) + std::visit(JsonBounds{}, field.kind);
}

}  // namespace

std::string value_text(const Field& field) {
  const auto value = field.member.get();
  return value ? std::visit(ValueText{}, *value) : "";
}

Schema expanded(const Schema& schema) {
  return expanded(schema, schema);
}

std::string print_keys(const Schema& schema) {
  std::string text;
  for (const Field& field : schema.fields) {
    text += (text.empty() ? "" : ",\n") + std::string{"{"} + described(field) + "}";
  }
  return "[" + text + "]";
}

std::string print_running(const Schema& schema) {
  std::string text;
  for (const Field& field : expanded(schema).fields) {
    text += (text.empty() ? "" : ",\n") + std::string{"{"} + described(field) + ", \"changes\": \"" +
            to_string(field.changes) + "\", \"value\": " + json_value(field) + "}";
  }
  return "[" + text + "]";
}

std::string print_json(const Schema& schema) {
  std::string text;
  for (const Field& field : expanded(schema).fields) {
    text += (text.empty() ? "" : ",\n") + quoted(field.path) + ": ";
    text += json_value(field);
  }
  return "{" + text + "}";
}

std::string print(const Schema& described, const Schema& described_defaults) {
  const Schema schema = expanded(described, described);
  const Schema defaults = expanded(described_defaults, described);
  std::string text;
  std::string table;
  for (std::size_t i = 0; i < schema.fields.size(); ++i) {
    const Field& field = schema.fields[i];
    const std::size_t dot = field.path.rfind('.');
    const std::string parent = dot == std::string::npos ? "" : field.path.substr(0, dot);
    if (parent != table) text += "\n" + heading(parent) + "\n";
    table = parent;
    const std::string key = field.path.substr(dot == std::string::npos ? 0 : dot + 1);
    const std::string value = value_text(field);
    if (value.empty() || is_left_out(schema, field)) text += "# ";
    text.append(key).append(value.empty() ? " =" : " = ").append(value);
    text += comment(field, value_text(defaults.fields[i])) + "\n";
  }
  return text;
}

}  // namespace sextant
