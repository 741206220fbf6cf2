#include "printer.hpp"

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

/// The value as TOML; empty for an optional one that is not set.
struct Value {
  std::string operator()(const NumberField& f) const {
    const auto x = f.get();
    return x ? number_text(*x) : "";
  }
  std::string operator()(const IntegerField& f) const {
    const auto x = f.get();
    return x ? std::to_string(*x) : "";
  }
  std::string operator()(const FlagField& f) const { return f.get() ? "true" : "false"; }
  std::string operator()(const TextField& f) const { return quoted(f.get()); }
  std::string operator()(const ChoiceField& f) const { return quoted(f.get()); }
  std::string operator()(const PointsField& f) const {
    std::string text;
    for (const auto& [first, second] : f.get()) {
      text += (text.empty() ? "[" : ", [") + number_text(first) + ", " + number_text(second) + "]";
    }
    return "[" + text + "]";
  }
  std::string operator()(const FileField& f) const { return f.get().empty() ? "" : quoted(f.get()); }
};

std::string comment(const Field& field, const std::string& preset) {
  std::string text = "  # " + field.meaning;
  if (!field.unit.empty()) text += " [" + field.unit + "]";
  text += "; " + expected(field.kind);
  if (field.required) return text + "; required";
  return text + "; default " + (preset.empty() ? "not set" : preset);
}

}  // namespace

std::string print(const Schema& schema, const Schema& defaults) {
  std::string text;
  std::string table;
  for (std::size_t i = 0; i < schema.fields.size(); ++i) {
    const Field& field = schema.fields[i];
    const std::size_t dot = field.path.rfind('.');
    const std::string parent = dot == std::string::npos ? "" : field.path.substr(0, dot);
    if (parent != table) text += "\n[" + parent + "]\n";
    table = parent;
    const std::string key = field.path.substr(dot == std::string::npos ? 0 : dot + 1);
    const std::string value = std::visit(Value{}, field.kind);
    if (value.empty()) text += "# ";
    text.append(key).append(value.empty() ? " =" : " = ").append(value);
    text += comment(field, std::visit(Value{}, defaults.fields[i].kind)) + "\n";
  }
  return text;
}

}  // namespace sextant
