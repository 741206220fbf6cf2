#include "ecu/replay/cycle_replay.hpp"

#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "ecu/unit/run_report.hpp"
#include "sextant/config/load_config.hpp"

namespace sextant::ecu {
namespace {

char letter(LegState leg) {
  return leg == LegState::off ? '-' : leg == LegState::high ? '1' : '0';
}

/// "100 for 25 us": legs a, b, c; "-" is off; "none" where gates stay off.
std::string text_of(const GatePattern& pattern) {
  if (pattern.segments().empty()) return "none";
  std::vector<std::string> parts;
  for (const GateSegment& part : pattern.segments()) {
    parts.push_back(fmt::format("{}{}{} for {:g} us", letter(part.state.a()), letter(part.state.b()),
                                letter(part.state.c()), double(part.duration_ns) * 1e-3));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace

CycleReplay::CycleReplay(const std::string& file, const std::vector<std::string>& overrides,
                         const EcuExtensions& own, const std::string& telemetry_out)
    : file_{file},
      reader_{file},
      is_changed_{!overrides.empty()},
      config_{load_ecu_config_text(reader_.configuration(), file + ": configuration", overrides, own)},
      drive_{config_.drive} {
  require_recorded_period(own);
  if (reader_.size() == 0) throw std::runtime_error{file + " has no control period"};
  if (!telemetry_out.empty()) {
    telemetry_.emplace(telemetry_out, config_.drive.drive.period_ns, periods_per_sample(config_),
                       std::nullopt, config_.drive.method().channels());
  }
}

void CycleReplay::require_recorded_period(const EcuExtensions& own) const {
  const EcuConfig recorded =
      load_ecu_config_text(reader_.configuration(), file_ + ": configuration", {}, own);
  if (recorded.drive.drive.period_ns == config_.drive.drive.period_ns) return;
  throw std::runtime_error{
      fmt::format("drive.period_us is that of the recording ({:g} us): leave it out of --set",
                  double(recorded.drive.drive.period_ns) * 1e-3)};
}

void CycleReplay::run() {
  for (auto records = reader_.next(); !records.empty(); records = reader_.next()) {
    for (const CycleRecord<double>& record : records) step(record);
  }
  if (telemetry_) telemetry_->close();
}

void CycleReplay::step(const CycleRecord<double>& record) {
  if (periods_ == 0) begin_ns_ = record.t_ns;
  end_ns_ = record.t_ns;
  const DriveOutput<double> output = drive_.drive().step(record.t_ns, record.measurement, record.request);
  if (output.pattern != record.pattern) {
    ++different_;
    if (!first_) first_ = {periods_, record.t_ns, record.pattern, output.pattern};
  }
  ++periods_;
  tripped_.reset();
  if (output.telemetry.latched.any()) tripped_ = output.telemetry.first_fault;
  if (!telemetry_) return;
  interval_.add(output.telemetry);
  if (interval_.count() < periods_per_sample(config_)) return;
  telemetry_->add(interval_.record(), drive_.controller().channel_values());
  interval_.reset();
}

Verdict CycleReplay::verdict() const noexcept {
  if (tripped_) return Verdict::tripped;
  return different_ > 0 ? Verdict::fail : Verdict::pass;
}

std::string CycleReplay::reason() const {
  return tripped_ ? tripped_text(*tripped_, file_) : "";
}

void CycleReplay::print_report(std::FILE* out) const {
  fmt::print(out, "{}: {} control periods, {:.3f} s, recorded by version {}\n", file_, periods_,
             double(end_ns_ - begin_ns_) * 1e-9, reader_.version());
  if (!reader_.dropped()) {
    fmt::print(out, "  the recording was not closed: its end is missing\n");
  } else if (*reader_.dropped() > 0) {
    fmt::print(
        out, "  {} control periods are not in the recording: after the first gap the replay is another run\n",
        *reader_.dropped());
  }
  fmt::print(out, "{} of {} gate patterns as recorded{}\n", periods_ - different_, periods_,
             is_changed_ ? ", with another configuration" : "");
  if (first_) {
    fmt::print(
        out,
        "  the first other one in period {}, {:.6f} s after the first\n    recorded: {}\n    replayed: {}\n",
        first_->period, double(first_->t_ns - begin_ns_) * 1e-9, text_of(first_->recorded),
        text_of(first_->replayed));
  }
}

}  // namespace sextant::ecu
