#include "sextant/files/replace_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include <unistd.h>

#include "sextant/files/resolved_path.hpp"

namespace sextant {
namespace {

namespace fs = std::filesystem;

/// Writes a text into a file of these permissions, `unknown` for those that it has. Gives the reason where
/// that fails, else nothing.
std::string write(const fs::path& file, fs::perms permissions, std::string_view text) {
  errno = 0;
  std::ofstream out{file, std::ios::binary | std::ios::trunc};
  if (!out) return std::strerror(errno);
  std::error_code ignored;  // a file system without permissions
  if (permissions != fs::perms::unknown) fs::permissions(file, permissions, ignored);
  out << text;
  out.close();
  return out ? "" : std::strerror(errno);
}

/// `write` into a file beside the old one, which then takes its place.
std::string replace(const fs::path& file, fs::perms permissions, std::string_view text) {
  fs::path part = file;
  part += "." + std::to_string(::getpid()) + ".part";
  std::string reason = write(part, permissions, text);
  std::error_code error;
  if (reason.empty()) {
    fs::rename(part, file, error);
    if (error) reason = error.message();
  }
  if (!reason.empty()) fs::remove(part, error);
  return reason;
}

std::string write_or_replace(const fs::path& file, std::string_view text) {
  std::error_code error;
  const fs::file_status old = fs::status(file, error);
  if (!fs::status_known(old)) return error.message();
  const fs::path target = resolved_path(file);
  // What is still a link then leads to a file without a name.
  const bool can_be_replaced = !fs::exists(old) || (fs::is_regular_file(old) && !fs::is_symlink(target));
  if (!can_be_replaced) return write(file, fs::perms::unknown, text);
  return replace(target, fs::exists(old) ? old.permissions() : fs::perms::unknown, text);
}

}  // namespace

void replace_file(const fs::path& file, std::string_view text, const std::string& what) {
  const std::string reason = write_or_replace(file, text);
  if (!reason.empty()) throw std::runtime_error{file.string() + ": cannot write " + what + ": " + reason};
}

}  // namespace sextant
