#include "ecu/virtual_time/lockstep_client.hpp"

#include <csignal>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "sextant/virtual_time/candump_log.hpp"

namespace sextant::ecu {

LockstepClient::LockstepClient(std::istream& in, std::FILE* out, VirtualCanBus& bus, std::string interface)
    : in_{in}, out_{out}, bus_{bus} {
  std::signal(SIGPIPE, SIG_IGN);
  bus_.listen([this, name = std::move(interface)](const CanFrame& frame) {
    write(format_candump({frame.received_ns, name, frame}));
  });
}

VirtualParty LockstepClient::party() {
  return {.next_due_ns = [this] { return next_ns_; }, .act = [this] { act(); }};
}

void LockstepClient::act() {
  if (frame_) bus_.put(*frame_);
  frame_.reset();
  if (std::exchange(wants_reply_, false)) {
    write(format_candump_time(next_ns_));
    std::fflush(out_);
  }
  if (std::ferror(out_) != 0) {
    next_ns_ = never_ns;  // nobody reads
    return;
  }
  read_line();
}

void LockstepClient::write(const std::string& line) noexcept {
  std::fputs(line.c_str(), out_);
  std::fputc('\n', out_);
}

void LockstepClient::read_line() {
  std::string line;
  if (!std::getline(in_, line)) {
    next_ns_ = never_ns;
    return;
  }
  ++lines_;
  try {
    const std::int64_t t_ns = parse_candump_time(line);
    if (t_ns < next_ns_) throw std::runtime_error{"the time goes back"};
    next_ns_ = t_ns;
    wants_reply_ = line.find_last_not_of(" \t\r") == line.find(')');
    if (!wants_reply_) frame_ = parse_candump(line).frame;
  } catch (const std::runtime_error& problem) {
    throw std::runtime_error{fmt::format("the standard input, line {}: {}", lines_, problem.what())};
  }
}

}  // namespace sextant::ecu
