#include "sextant/files/text_lines.hpp"

#include <array>
#include <cerrno>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace sextant {

std::string why_unreadable(const std::string& file) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (fs::is_directory(status)) return "cannot be read: it is a directory";
  if (fs::is_character_file(status) || fs::is_block_file(status)) {
    return "cannot be read: it is a device; name a file or a pipe";
  }
  if (fs::is_fifo(status)) return {};  // opening one would wait for its writer
  const std::ifstream stream{file};
  return stream ? std::string{} : "cannot be read: " + std::generic_category().message(errno);
}

TextLines::TextLines(std::string file) : file_{std::move(file)} {
  if (const std::string reason = why_unreadable(file_); !reason.empty()) {
    throw std::runtime_error(file_ + " " + reason);
  }
  errno = 0;
  stream_.open(file_);
  if (!stream_)
    throw std::runtime_error(file_ + " cannot be read: " + std::generic_category().message(errno));
}

bool TextLines::next(std::string& line) {
  std::array<char, longest_line + 1> text;
  stream_.getline(text.data(), text.size());
  const auto read = static_cast<std::size_t>(stream_.gcount());
  if (stream_.bad()) {
    throw std::runtime_error(file_ + " cannot be read to its end: an error behind line " +
                             std::to_string(number_));
  }
  if (read == 0) return false;
  ++number_;
  if (stream_.fail())
    refuse("the line is longer than " + std::to_string(longest_line) + " bytes; is it a text file?");
  if (number_ > most_lines) refuse("more than " + std::to_string(most_lines) + " lines; cut the file");
  // The end of a line counts among what was read, the end of the file does not.
  line.assign(text.data(), stream_.eof() ? read : read - 1);
  return true;
}

void TextLines::refuse(const std::string& what) const {
  throw std::runtime_error(file_ + ":" + std::to_string(number_) + ": " + what);
}

}  // namespace sextant
