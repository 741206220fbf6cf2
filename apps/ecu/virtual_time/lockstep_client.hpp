#pragma once

#include <cstdint>
#include <cstdio>
#include <istream>
#include <optional>
#include <string>

#include "sextant/comms/can_frame.hpp"
#include "sextant/virtual_time/virtual_can_bus.hpp"
#include "sextant/virtual_time/virtual_timeline.hpp"

namespace sextant::ecu {

/// A program that takes part in virtual time over two streams of lines, in the format of candump_log.hpp. A
/// line with a frame puts it on the bus at its time; a line with a time alone, "(0.01)", asks to go on until
/// then. Virtual time waits for the next line. The frames that drives send are written as they are sent, and
/// a line with the time once it is reached. The end of the input ends the run, as does an output that nobody
/// reads, of which the program gets no signal.
class LockstepClient {
 public:
  /// Streams and bus are not owned and must outlive this object, which must stay where it is.
  /// interface: its name in the lines.
  LockstepClient(std::istream& in, std::FILE* out, VirtualCanBus& bus, std::string interface);
  LockstepClient(const LockstepClient&) = delete;
  LockstepClient& operator=(const LockstepClient&) = delete;

  /// Throws std::runtime_error with the number of the line where one is none, or where its time goes back.
  [[nodiscard]] VirtualParty party();

  [[nodiscard]] bool is_over() const noexcept { return next_ns_ == never_ns; }

 private:
  void act();
  void write(const std::string& line) noexcept;
  void read_line();

  std::istream& in_;
  std::FILE* out_;
  VirtualCanBus& bus_;
  std::int64_t next_ns_{0};  // of the line that waits; never_ns: the input has ended
  std::optional<CanFrame> frame_{};
  bool wants_reply_{false};
  std::uint64_t lines_{0};
};

}  // namespace sextant::ecu
