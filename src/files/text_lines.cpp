#include "sextant/files/text_lines.hpp"

#include <cerrno>
#include <filesystem>
#include <stdexcept>
#include <string_view>
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
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  line.clear();
  char byte{};
  bool is_there = false;
  while (stream_.get(byte)) {
    if (!is_there) ++number_;
    is_there = true;
    if (ends_line(byte)) break;
    if (line.size() == longest_line)
      refuse("the line is longer than " + std::to_string(longest_line) + " bytes; is it a text file?");
    line.push_back(byte);
  }
  if (stream_.bad()) {
    throw std::runtime_error(file_ + " cannot be read to its end: an error behind line " +
                             std::to_string(number_));
  }
  if (!is_there) return false;
  if (number_ > most_lines) refuse("more than " + std::to_string(most_lines) + " lines; cut the file");
  if (number_ == 1 && line.starts_with(byte_order_mark)) line.erase(0, byte_order_mark.size());
  return true;
}

bool TextLines::ends_line(char byte) {
  if (byte == '\r' && stream_.peek() == '\n') stream_.ignore();
  return byte == '\n' || byte == '\r';
}

void TextLines::refuse(const std::string& what) const {
  throw std::runtime_error(file_ + ":" + std::to_string(number_) + ": " + what);
}

}  // namespace sextant
