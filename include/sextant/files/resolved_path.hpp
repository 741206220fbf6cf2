#pragma once

#include <filesystem>

namespace sextant {

/// The file that a path leads to: absolute, links followed, also a link to what is not there yet. Where the
/// system cannot resolve it (a ring of links, an anonymous pipe) the absolute path itself.
[[nodiscard]] std::filesystem::path resolved_path(const std::filesystem::path& file);

}  // namespace sextant
