#include "ecu/unit/cycle_log.hpp"

#include <cstdint>
#include <memory>
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

CycleLog::CycleLog(const std::string& file, const EcuConfig& config)
    : file_{file}, configuration_{print_config(config)}, recorder_{room(config)} {
  waiting_.reserve(most_at_once);
}

void CycleLog::open() {
  writer_ = std::make_unique<CycleFileWriter>(file_, configuration_);
}

template <class Write>
void CycleLog::guarded(Write&& write) {
  if (!writer_ || !failure_.empty()) return;
  try {
    write();
  } catch (const std::runtime_error& problem) {
    failure_ = fmt::format("{}; its first {} control periods are kept", problem.what(), writer_->written());
  }
}

void CycleLog::poll() {
  guarded([this] { write_waiting(); });
}

void CycleLog::write_waiting() {
  do {
    waiting_.clear();
    CycleRecord<double> record;
    while (waiting_.size() < most_at_once && recorder_.records().pop(record)) waiting_.push_back(record);
    if (!waiting_.empty()) writer_->append(waiting_);
  } while (waiting_.size() == most_at_once);
}

void CycleLog::close() {
  guarded([this] {
    write_waiting();
    writer_->close(recorder_.dropped());
  });
}

void CycleLog::print_report(std::FILE* out) const {
  if (!writer_) return;
  fmt::print(out, "{}: {} control periods recorded", file_, writer_->written());
  if (!failure_.empty()) {
    fmt::print(out, ", then none");
  } else if (const std::uint64_t lost = recorder_.dropped(); lost > 0) {
    fmt::print(out, ", {} lost: the disk was too slow", lost);
  }
  fmt::print(out, "\n");
}

}  // namespace sextant::ecu
