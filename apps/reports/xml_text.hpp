#pragma once

#include <string>
#include <string_view>

namespace sextant::reports {

/// A text that XML 1.0 can hold: UTF-8, with a `?` for each byte that is none, and for each character that
/// XML leaves out (control characters but tab, line feed and carriage return; U+FFFE and U+FFFF).
[[nodiscard]] std::string xml_text(std::string_view text);

}  // namespace sextant::reports
