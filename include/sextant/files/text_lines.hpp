#pragma once

#include <cstddef>
#include <fstream>
#include <string>

namespace sextant {

/// Why a file cannot be read, as the end of a sentence that begins with its name: it is missing, closed to
/// this user, a directory, or a device, which may have no end. Empty for a regular file, a pipe or a socket.
[[nodiscard]] std::string why_unreadable(const std::string& file);

/// A text file, line by line; lines end in LF, CR LF or CR, and a byte order mark at the beginning is passed
/// over. Whatever is in it, the reader's time and memory are bounded: by the length of a
/// line, and by how many there may be.
class TextLines {
 public:
  static constexpr std::size_t longest_line = 4096;  ///< [bytes]
  static constexpr int most_lines = 10'000'000;      ///< [-]

  /// Throws std::runtime_error with the file and the reason where it cannot be read.
  explicit TextLines(std::string file);

  /// The next line, without its end; false after the last. Throws std::runtime_error with file and line where
  /// the line is too long, there are too many, or the file cannot be read on.
  [[nodiscard]] bool next(std::string& line);

  /// Of the line that was read last, from 1; 0 before the first. [-]
  [[nodiscard]] int number() const noexcept { return number_; }

  /// Throws std::runtime_error: file, line, and what is wrong there.
  [[noreturn]] void refuse(const std::string& what) const;

 private:
  /// True at the end of a line, of which the second byte of CR LF is passed over.
  [[nodiscard]] bool ends_line(char byte);

  std::string file_;
  std::ifstream stream_;
  int number_{0};
};

}  // namespace sextant
