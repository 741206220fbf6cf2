#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace sextant {

/// Writes a file so that a reader finds the old file or the new one, never a part. A link is followed, and an
/// old file's permissions are kept. A device or a pipe is written into as it stands. Throws
/// std::runtime_error "FILE: cannot write WHAT: REASON".
void replace_file(const std::filesystem::path& file, std::string_view text, const std::string& what);

}  // namespace sextant
