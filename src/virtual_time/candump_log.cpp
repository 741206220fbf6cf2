#include "sextant/virtual_time/candump_log.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <map>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sextant/files/text_lines.hpp"

namespace sextant {
namespace {

constexpr std::int64_t ns_per_second = 1'000'000'000;
constexpr std::int64_t longest_gap_ns = std::int64_t{24} * 3600 * ns_per_second;
constexpr std::uint32_t error_flag = 0x2000'0000;  // CAN_ERR_FLAG of linux/can.h
constexpr std::uint32_t extended_mask = 0x1FFF'FFFF;

template <class... Args>
[[noreturn]] void refuse(fmt::format_string<Args...> text, Args&&... args) {
  throw std::runtime_error{fmt::format(text, std::forward<Args>(args)...)};
}

/// The next word of the line, which is left behind it; empty at the end.
std::string_view next_word(std::string_view& line) {
  constexpr std::string_view blank = " \t\r";
  const std::size_t begin = std::min(line.find_first_not_of(blank), line.size());
  const std::size_t end = std::min(line.find_first_of(blank, begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

/// The whole text as an unsigned number, or nothing.
template <class Number>
std::optional<Number> number(std::string_view text, int base) {
  Number x{};
  const auto result = std::from_chars(text.data(), text.data() + text.size(), x, base);
  const bool whole = result.ec == std::errc{} && result.ptr == text.data() + text.size();
  if (!whole || text.empty() || text.front() == '-') return std::nullopt;
  return x;
}

/// "(seconds.fraction)"
std::int64_t parse_time(std::string_view word) {
  constexpr std::size_t digits = 9;
  const std::size_t dot = word.find('.');
  const bool framed = word.size() > 2 && word.front() == '(' && word.back() == ')';
  if (framed && dot != std::string_view::npos && word.size() - dot - 2 <= digits) {
    const std::string_view fraction = word.substr(dot + 1, word.size() - dot - 2);
    const auto seconds = number<std::int64_t>(word.substr(1, dot - 1), 10);
    const auto part =
        number<std::int64_t>(std::string(fraction) + std::string(digits - fraction.size(), '0'), 10);
    if (seconds && part && !fraction.empty() && *seconds < 9'000'000'000)
      return *seconds * ns_per_second + *part;
  }
  refuse("expected a time as (1699999999.123456), found \"{:.40}\"", word);
}

void parse_identifier(std::string_view text, CanFrame& frame) {
  const std::optional<std::uint32_t> id = number<std::uint32_t>(text, 16);
  if (!id || (text.size() != 3 && text.size() != 8)) {
    refuse("expected an identifier of 3 or 8 hexadecimal digits, found \"{:.40}\"", text);
  }
  frame.error = text.size() == 8 && (*id & error_flag) != 0;
  frame.extended = text.size() == 8 && !frame.error;
  frame.id = *id & extended_mask;
  const bool too_large =
      frame.error ? *id >= 2 * error_flag : *id > (frame.extended ? extended_mask : 0x7FFU);
  if (too_large) refuse("the identifier {} has more than {} bits", text, frame.extended ? 29 : 11);
}

void parse_data(std::string_view text, CanFrame& frame) {
  const std::size_t most = frame.fd ? 64 : 8;
  if (text.size() % 2 != 0 || text.size() / 2 > most) {
    refuse("expected up to {} bytes of two hexadecimal digits each, found \"{:.40}\"", most, text);
  }
  frame.length = static_cast<std::uint8_t>(text.size() / 2);
  for (std::size_t k = 0; k < frame.length; ++k) {
    const auto byte = number<std::uint8_t>(text.substr(2 * k, 2), 16);
    if (!byte) refuse("\"{}\" is no byte in hexadecimal digits", text.substr(2 * k, 2));
    frame.data[k] = *byte;
  }
}

void parse_remote(std::string_view length, CanFrame& frame) {
  frame.rtr = true;
  if (length.empty()) return;
  const auto bytes = number<std::uint8_t>(length, 10);
  if (!bytes || *bytes > 8) refuse("a remote request has a length from 0 to 8, not \"{:.40}\"", length);
  frame.length = *bytes;
}

/// What follows _ behind eight bytes: the raw data length code of the frame.
void check_length_code(std::string_view code, const CanFrame& frame) {
  const auto value = number<std::uint8_t>(code, 16);
  if (code.size() != 1 || !value || *value < 9 || frame.length != 8) {
    refuse("expected one digit from 9 to F behind eight bytes and _, found \"_{:.40}\"", code);
  }
}

CanFrame parse_frame(std::string_view text) {
  const std::size_t hash = text.find('#');
  if (hash == std::string_view::npos) refuse("expected a frame as 110#0C10000098, found \"{:.40}\"", text);
  CanFrame frame;
  parse_identifier(text.substr(0, hash), frame);
  std::string_view rest = text.substr(hash + 1);
  if (rest.starts_with('#')) {
    frame.fd = true;
    if (rest.size() < 2 || !number<std::uint8_t>(rest.substr(1, 1), 16)) {
      refuse("expected a digit of flags after ## of a CAN FD frame, found \"{:.40}\"", text);
    }
    parse_data(rest.substr(2), frame);
    return frame;
  }
  if (const std::size_t xl = rest.find('#'); xl != std::string_view::npos) {
    refuse("CAN XL frames cannot be read: \"{}\"", text);
  }
  const std::size_t code = rest.find('_');
  const std::string_view payload = rest.substr(0, code);
  if (payload.starts_with('R') || payload.starts_with('r')) {
    parse_remote(payload.substr(1), frame);
  } else {
    parse_data(payload, frame);
  }
  if (code != std::string_view::npos) check_length_code(rest.substr(code + 1), frame);
  return frame;
}

/// Of two frames of an interface that follow each other.
void check_order(std::int64_t before_ns, std::int64_t t_ns) {
  if (t_ns < before_ns) refuse("the time goes back; a log must be in order of time");
  if (t_ns - before_ns <= longest_gap_ns) return;
  refuse("the time jumps ahead by {:.6f} s; a log may have gaps of {} s: correct the time, or cut the log",
         double(t_ns - before_ns) / double(ns_per_second), longest_gap_ns / ns_per_second);
}

}  // namespace

LoggedFrame parse_candump(std::string_view line) {
  LoggedFrame logged;
  logged.t_ns = parse_time(next_word(line));
  logged.interface = next_word(line);
  if (logged.interface.empty()) refuse("expected the name of an interface after the time, found nothing");
  logged.frame = parse_frame(next_word(line));
  const std::string_view direction = next_word(line);
  const bool known = direction.empty() || direction == "R" || direction == "T";
  if (!known || !next_word(line).empty()) refuse("expected nothing but R or T after the frame");
  return logged;
}

std::int64_t parse_candump_time(std::string_view line) {
  return parse_time(next_word(line));
}

std::string format_candump_time(std::int64_t t_ns) {
  return fmt::format("({:010}.{:06})", t_ns / ns_per_second, t_ns % ns_per_second / 1000);
}

std::string format_candump(const LoggedFrame& logged) {
  const CanFrame& frame = logged.frame;
  std::string text = format_candump_time(logged.t_ns) + fmt::format(" {} ", logged.interface);
  if (frame.error) {
    text += fmt::format("{:08X}#", frame.id | error_flag);
  } else {
    text += frame.extended ? fmt::format("{:08X}#", frame.id) : fmt::format("{:03X}#", frame.id);
  }
  if (frame.fd) text += "#0";
  // Without a length where that is zero: python-can reads both, older can-utils only this.
  if (frame.rtr) return text + (frame.length == 0 ? "R" : fmt::format("R{}", frame.length));
  for (std::size_t k = 0; k < frame.length; ++k) text += fmt::format("{:02X}", frame.data[k]);
  return text;
}

std::vector<LoggedFrame> read_candump(const std::string& file) {
  TextLines lines{file};
  std::vector<LoggedFrame> log;
  std::map<std::string, std::int64_t> newest_ns;  // by interface: a log may hold one bus after the other
  for (std::string line; lines.next(line);) {
    std::string_view rest = line;
    if (next_word(rest).empty()) continue;
    try {
      log.push_back(parse_candump(line));
      const auto [before, is_first] = newest_ns.try_emplace(log.back().interface, log.back().t_ns);
      if (!is_first) check_order(std::exchange(before->second, log.back().t_ns), log.back().t_ns);
    } catch (const std::runtime_error& problem) {
      lines.refuse(problem.what());
    }
  }
  if (log.empty())
    refuse("{} holds no frame: expected lines as (1699999999.123456) can0 110#0C10000098", file);
  return log;
}

std::vector<LoggedFrame> select_interface(const std::vector<LoggedFrame>& log, const std::string& interface,
                                          const std::string& file) {
  std::vector<std::string> names;
  for (const LoggedFrame& logged : log) {
    if (std::ranges::find(names, logged.interface) == names.end()) names.push_back(logged.interface);
  }
  if (interface.empty() && names.size() == 1) return log;
  if (interface.empty() || std::ranges::find(names, interface) == names.end()) {
    refuse("{} holds frames of {}: name one of them", file, fmt::join(names, ", "));
  }
  std::vector<LoggedFrame> selected;
  std::ranges::copy_if(log, std::back_inserter(selected),
                       [&](const LoggedFrame& logged) { return logged.interface == interface; });
  return selected;
}

CandumpWriter::CandumpWriter(std::string file)
    : file_{std::move(file)}, stream_{std::fopen(file_.c_str(), "w")} {
  if (!stream_) refuse("{} cannot be written: {}", file_, std::generic_category().message(errno));
}

void CandumpWriter::add(const LoggedFrame& logged) noexcept {
  if (std::ferror(stream_.get()) != 0) return;
  const std::string line = format_candump(logged) + '\n';
  (void)std::fwrite(line.data(), 1, line.size(), stream_.get());
}

void CandumpWriter::close() {
  if (!stream_) return;
  const bool failed = std::ferror(stream_.get()) != 0;
  errno = 0;
  if (std::fclose(stream_.release()) != 0 || failed) {
    refuse("{} cannot be written: {}", file_,
           errno == 0 ? std::string{"an error of the file system"} : std::generic_category().message(errno));
  }
}

}  // namespace sextant
