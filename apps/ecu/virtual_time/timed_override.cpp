#include "ecu/virtual_time/timed_override.hpp"

#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

namespace sextant::ecu {

std::vector<TimedOverride> timed_overrides(const std::vector<std::string>& at) {
  std::vector<TimedOverride> overrides;
  overrides.reserve(at.size());
  for (const std::string& text : at) {
    double t_s = -1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), t_s);
    if (error != std::errc{} || end == text.data() + text.size() || *end != ':' || !(t_s >= 0 && t_s < 1e9)) {
      throw std::runtime_error{
          fmt::format("--set-at: expected TIME:KEY=VALUE with a time in seconds, got \"{}\"", text)};
    }
    overrides.push_back({std::llround(t_s * 1e9), drive_override(std::string_view{end + 1})});
  }
  return overrides;
}

}  // namespace sextant::ecu
