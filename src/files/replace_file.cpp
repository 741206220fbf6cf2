#include "sextant/files/replace_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include <unistd.h>

namespace sextant {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& what,
                       const std::string& reason) {
  throw std::runtime_error{file.string() + ": cannot write " + what + ": " + reason};
}

}  // namespace

void replace_file(const std::filesystem::path& file, std::string_view text, const std::string& what) {
  std::filesystem::path part = file;
  part += "." + std::to_string(::getpid()) + ".part";
  std::error_code ignored;
  errno = 0;
  std::ofstream out{part, std::ios::binary | std::ios::trunc};
  if (!out) fail(file, what, std::strerror(errno));
  out << text;
  out.close();
  if (!out) {
    const std::string reason = std::strerror(errno);
    std::filesystem::remove(part, ignored);
    fail(file, what, reason);
  }
  std::error_code error;
  std::filesystem::rename(part, file, error);
  if (error) {
    std::filesystem::remove(part, ignored);
    fail(file, what, error.message());
  }
}

}  // namespace sextant
