#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sextant/comms/can_frame.hpp"

namespace sextant {

// The log format of can-utils (`candump -l`, `canplayer`) and python-can (`.log`), one frame a line:
//   (1699999999.123456) can0 110#0C10000098 3A0000   without the blank; three hex digits: 11-bit identifier
//   (…) can0 00000110#…      eight hex digits: 29-bit; with bit 0x20000000: an error frame
//   (…) can0 110#R8          remote request, with or without a length
//   (…) can0 110##0…         CAN FD, one hex digit of flags (bit-rate switch, error state), which are not
//   kept
// A direction at the end (R or T, python-can) and the raw length code of classic frames (_9 to _F) are passed
// over. CAN XL is refused.

/// A frame of a log.
struct LoggedFrame {
  std::int64_t t_ns{};      ///< as in the log, mostly since 1970 [ns]
  std::string interface{};  ///< name of the interface
  CanFrame frame{};         ///< `received_ns` is zero
};

/// Reads one line. Throws std::runtime_error with the mistake.
[[nodiscard]] LoggedFrame parse_candump(std::string_view line);

/// The time at the beginning of a line [ns]. Throws as parse_candump.
[[nodiscard]] std::int64_t parse_candump_time(std::string_view line);

/// The beginning of a line, the time to the microsecond below. [ns]
[[nodiscard]] std::string format_candump_time(std::int64_t t_ns);

/// The frame as a line, without its end; the time to the microsecond below, as canplayer reads it.
[[nodiscard]] std::string format_candump(const LoggedFrame& logged);

/// Reads a log, in the order of its lines; empty lines are passed over. Throws std::runtime_error that names
/// file and line, also where the time of an interface goes back or jumps ahead by more than a day, and beyond
/// the bounds of TextLines. An empty log is refused.
[[nodiscard]] std::vector<LoggedFrame> read_candump(const std::string& file);

/// The frames of one interface; an empty name: of the only one there is. Throws std::runtime_error that names
/// the interfaces of the log where that gives none.
[[nodiscard]] std::vector<LoggedFrame> select_interface(const std::vector<LoggedFrame>& log,
                                                        const std::string& interface,
                                                        const std::string& file);

/// Writes a log.
class CandumpWriter {
 public:
  /// Replaces a file of that name. Throws std::runtime_error with file and reason.
  explicit CandumpWriter(std::string file);

  /// After an error of writing this does nothing.
  void add(const LoggedFrame& logged) noexcept;

  /// Closes the file. Throws std::runtime_error where something could not be written.
  void close();

 private:
  struct Close {
    void operator()(std::FILE* f) const noexcept { std::fclose(f); }
  };
  std::string file_;
  std::unique_ptr<std::FILE, Close> stream_;
};

}  // namespace sextant
