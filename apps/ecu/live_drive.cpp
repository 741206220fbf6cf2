#include "ecu/live_drive.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "common/process_setup.hpp"
#include "ecu/timing/timing_report.hpp"
#include "ecu/unit/run_report.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {
namespace {

TelemetryTask::Parameters telemetry_parameters(const EcuConfig& config) {
  const std::int64_t wake_period_ns =
      std::int64_t{config.drive.drive.period_ns} * config.realtime.wake_every_periods;
  return {.period_ns = config.drive.drive.period_ns,
          .wake_every_periods = std::uint32_t(config.realtime.wake_every_periods),
          .periods_per_sample = periods_per_sample(config),
          .statistics_ns = std::int64_t(1e9 / config.dds.statistics_rate_hz),
          .timing = {config.realtime.gap_limit_ns, wake_period_ns},
          .wait = config.realtime.wait.mode,
          .policy = config.realtime.policy};
}

}  // namespace

LiveDrive::LiveDrive(const EcuConfig& config, CanBus& bus, const LiveDriveOptions& options)
    : prefix_{options.prefix},
      power_stage_{config, options.fault_socket, options.prefix},
      unit_{config, power_stage_.io(), bus, [this] { power_stage_.inhibit_gates(); }, options.record_cycles},
      housekeeping_{unit_.shared(), [this](const std::string& sentence) { warn(sentence); }},
      telemetry_{telemetry_parameters(config), sender_, unit_.shared(),
                 [this](const std::string& sentence) { warn(sentence); }},
      control_{config.realtime, unit_.io(),       unit_.control(),
               unit_.shared(),  unit_.recorder(), options.thread} {
  if (options.set_socket.empty()) return;
  changes_.emplace(config, options.load, unit_.shared());
  parameters_.emplace(options.set_socket, *changes_, prefix_);
}

void LiveDrive::prepare() {
  rights_ = control_.start();
  check_rights(unit_.config().realtime, rights_);
  warn_of_unbounded_execution();
  if (unit_.cycles() != nullptr) unit_.cycles()->open();
}

void LiveDrive::go() {
  control_.go();
  telemetry_.start(now_ns(), rights_);
  housekeeping_.start();
}

void LiveDrive::join() {
  control_.join();
  power_stage_.announce_end();
}

void LiveDrive::write_cycles() {
  CycleLog* const cycles = unit_.cycles();
  if (cycles == nullptr || !cycles->failure().empty()) return;
  cycles->poll();
  if (!cycles->failure().empty()) spdlog::error("{}recording: {}", prefix_, cycles->failure());
}

void LiveDrive::close() {
  if (unit_.cycles() != nullptr) unit_.cycles()->close();
}

void LiveDrive::warn_of_unbounded_execution() const {
  const EcuConfig& config = unit_.config();
  const IntegratorKind kind = config.drive.plant.integrator;
  const bool unbounded = kind == IntegratorKind::cvode || kind == IntegratorKind::erk;
  if (config.power_stage_kind() != PowerStageKind::simulated || config.realtime.wake_every_periods > 1 ||
      !unbounded) {
    return;
  }
  spdlog::warn(
      "{}real time: plant.integrator = \"{}\" has no bound on its time; with realtime.wake_every_periods = 1 "
      "a long step misses periods: take \"fixed\"",
      prefix_, kind == IntegratorKind::cvode ? "cvode" : "erk");
}

void LiveDrive::warn(const std::string& sentence) const {
  spdlog::warn("{}{}", prefix_.empty() ? "drive: " : prefix_, sentence);
}

bool LiveDrive::poll_link() {
  const std::string sentence = power_stage_.state_change();
  if (!sentence.empty()) spdlog::info("{}{}", prefix_, sentence);
  power_stage_.poll_faults();
  if (parameters_) parameters_->poll();
  return !power_stage_.problem().empty();
}

std::string LiveDrive::problem() const {
  if (std::string problem = power_stage_.problem(); !problem.empty()) return problem;
  return unit_.cycles() != nullptr ? unit_.cycles()->failure() : std::string{};
}

void LiveDrive::print_timing_and_commands(std::FILE* out) const {
  print_timing(out, telemetry_.timing());
  if (const std::uint64_t lost = unit_.shared().wakes.dropped(); lost > 0) {
    fmt::print(out,
               "  of {} wake-ups latency and execution time are not in these figures: the ring was full\n",
               lost);
  }
  power_stage_.print_report(out);
  print_commands(out, unit_.receive().receiver(), unit_.config().can.identifier_offset);
}

void LiveDrive::print_telemetry(std::FILE* out, const CountsMessage& counts) const {
  fmt::print(out, "telemetry {} published, {} periods dropped\n", counts.written,
             unit_.shared().telemetry.dropped());
  if (const std::uint64_t stalls = unit_.shared().telemetry_stalls.load(); stalls > 0) {
    fmt::print(out, "  the telemetry thread stopped {} times\n", stalls);
  }
  if (counts.refused > 0) {
    fmt::print(out, "  {} samples not published: a value was no finite number\n", counts.refused);
  }
  if (counts.failed > 0)
    fmt::print(out, "  {} samples not published: DDS reported an error\n", counts.failed);
  if (counts.incompatible_readers > 0) {
    fmt::print(out, "  {} readers without samples: they request a quality of service that is not offered\n",
               counts.incompatible_readers);
  }
  if (const std::uint64_t lost = sender_.dropped(); lost > 0) {
    fmt::print(out, "  {} samples not published: sextant-telemetry did not receive them\n", lost);
  }
  if (unit_.cycles() != nullptr) unit_.cycles()->print_report(out);
}

}  // namespace sextant::ecu
