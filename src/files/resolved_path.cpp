#include "sextant/files/resolved_path.hpp"

#include <system_error>

namespace sextant {

namespace fs = std::filesystem;

fs::path resolved_path(const fs::path& file) {
  constexpr int most_links = 40;  // as many as the kernel follows
  std::error_code error;
  fs::path absolute = fs::absolute(file, error);
  fs::path path = absolute;
  for (int links = 0; links < most_links; ++links) {
    path = fs::weakly_canonical(path, error);
    if (error) break;
    std::error_code missing;
    if (!fs::is_symlink(path, missing)) return path;
    // A link is left only where its target does not exist.
    path = path.parent_path() / fs::read_symlink(path, missing);
  }
  return absolute;
}

}  // namespace sextant
