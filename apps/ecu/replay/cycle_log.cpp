#include "ecu/replay/cycle_log.hpp"

#include <stdexcept>

#include <fmt/format.h>

#include "sextant/config/load_config.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {
namespace {

/// A second: a disk that does not answer for less loses nothing.
std::size_t room(const EcuConfig& config) {
  return std::size_t(ns_per_s / config.drive.drive.period_ns) + 1;
}

}  // namespace

CycleLog::CycleLog(const std::string& file, const EcuConfig& config, DriveIo<double>& io)
    : file_{file}, recorder_{io, room(config)}, writer_{file, print_config(config)} {
  waiting_.reserve(most_at_once);
}

std::string CycleLog::poll() {
  if (!failure_.empty()) return {};
  try {
    write_waiting();
  } catch (const std::runtime_error& problem) {
    failure_ = fmt::format("{}; its first {} control periods are kept", problem.what(), writer_.written());
  }
  return failure_;
}

void CycleLog::write_waiting() {
  do {
    waiting_.clear();
    CycleRecord<double> record;
    while (waiting_.size() < most_at_once && recorder_.records().pop(record)) waiting_.push_back(record);
    if (!waiting_.empty()) writer_.append(waiting_);
  } while (waiting_.size() == most_at_once);
}

void CycleLog::close() {
  (void)poll();
  if (!failure_.empty()) throw std::runtime_error{failure_};
  writer_.close(recorder_.records().dropped());
}

void CycleLog::print_report(std::FILE* out) const {
  fmt::print(out, "{}: {} control periods recorded\n", file_, writer_.written());
}

}  // namespace sextant::ecu
