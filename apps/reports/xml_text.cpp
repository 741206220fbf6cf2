#include "reports/xml_text.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>

namespace sextant::reports {
namespace {

/// The character at the beginning of a text.
struct Character {
  char32_t code;
  std::size_t bytes;  ///< 0: the text does not begin with UTF-8
};

/// RFC 3629: neither a surrogate, nor more bytes than a character needs, nor one above U+10FFFF.
Character first_character(std::string_view text) {
  constexpr char32_t smallest[]{0, 0x80, 0x800, 0x10000};  // of 1, 2, 3 and 4 bytes
  const auto first = static_cast<unsigned char>(text.front());
  const auto ones = static_cast<std::size_t>(std::countl_one(first));
  const std::size_t bytes = std::max<std::size_t>(ones, 1);
  if (ones == 1 || bytes > 4 || bytes > text.size()) return {0, 0};
  char32_t code = first & (0xFFU >> ones);
  for (const char c : text.substr(1, bytes - 1)) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xC0U) != 0x80U) return {0, 0};
    code = code << 6 | (byte & 0x3FU);
  }
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (surrogate || code < smallest[bytes - 1] || code > 0x10FFFF) return {0, 0};
  return {code, bytes};
}

bool in_xml(char32_t code) {
  if (code < 0x20) return code == '\t' || code == '\n' || code == '\r';
  return code != 0xFFFE && code != 0xFFFF;
}

}  // namespace

std::string xml_text(std::string_view text) {
  std::string valid;
  while (!text.empty()) {
    const Character character = first_character(text);
    const std::size_t bytes = std::max<std::size_t>(character.bytes, 1);
    valid += character.bytes > 0 && in_xml(character.code) ? text.substr(0, bytes) : "?";
    text.remove_prefix(bytes);
  }
  return valid;
}

}  // namespace sextant::reports
