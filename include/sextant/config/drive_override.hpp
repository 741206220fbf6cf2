#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace sextant {

/// An override of the drives of a process: "key=value" for each of them, or "drive[ID].key=value" for the one
/// with that `drive_id`.
struct DriveOverride {
  std::optional<int> drive_id{};  ///< empty: each drive
  std::string text{};             ///< "key=value"

  [[nodiscard]] bool counts_for(int id) const noexcept { return !drive_id || *drive_id == id; }
};

[[nodiscard]] inline DriveOverride drive_override(std::string_view text) {
  constexpr std::string_view before = "drive[";
  constexpr std::string_view after = "].";
  int id = 0;
  if (text.starts_with(before)) {
    const std::string_view rest = text.substr(before.size());
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), id);
    const std::string_view behind = rest.substr(std::size_t(end - rest.data()));
    if (error == std::errc{} && behind.starts_with(after))
      return {id, std::string{behind.substr(after.size())}};
  }
  return {{}, std::string{text}};
}

/// The override for one drive alone; `text` is "key=value".
[[nodiscard]] inline std::string for_drive(int drive_id, const std::string& text) {
  return "drive[" + std::to_string(drive_id) + "]." + text;
}

}  // namespace sextant
