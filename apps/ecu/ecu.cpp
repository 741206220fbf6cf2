#include "ecu/ecu.hpp"

#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "sextant/config/make_controller.hpp"

namespace sextant::ecu {
namespace {

/// The profiles of the load begin with the drive, not with the machine's clock.
SimulatedPowerStage::Parameters power_stage_parameters(const EcuConfig& config) {
  SimulatedPowerStage::Parameters p = config.drive.plant;
  p.io.load_origin_ns.reset();
  return p;
}

TelemetryThread::Parameters telemetry_parameters(const EcuConfig& config) {
  const double period_s = double(config.drive.drive.period_ns) * 1e-9;
  TelemetryThread::Parameters p;
  p.period_ns = config.drive.drive.period_ns;
  p.wake_every_periods = std::uint32_t(config.realtime.wake_every_periods);
  p.periods_per_sample =
      std::max(1U, std::uint32_t(std::lround(1.0 / (config.dds.telemetry_rate_hz * period_s))));
  p.statistics_ns = std::int64_t(1e9 / config.dds.statistics_rate_hz);
  return p;
}

/// The configuration of Cyclone DDS, with defaults in front of it for leaving in time. A writer that goes
/// away waits until its readers have acknowledged everything, for 1 s unless told otherwise, and asks them
/// every 100 ms. What comes later in the list has the last word.
std::string dds_configuration(const EcuConfig& config) {
  std::string text =
      "<CycloneDDS><Domain><Internal><HeartbeatInterval min=\"2 ms\" minsched=\"5 ms\">10 "
      "ms</HeartbeatInterval>"
      "<WriterLingerDuration>30 ms</WriterLingerDuration></Internal></Domain></CycloneDDS>";
  const char* const environment = std::getenv("CYCLONEDDS_URI");
  const std::string given = !config.dds.config_uri.empty() ? config.dds.config_uri
                            : environment != nullptr       ? std::string{environment}
                                                           : std::string{};
  if (!given.empty()) text += "," + given;
  return text;
}

/// Where the part comes from that is not ours; empty where there is none.
std::string dds_configuration_source(const EcuConfig& config) {
  if (!config.dds.config_uri.empty()) return "dds.config_uri = \"" + config.dds.config_uri + "\"";
  const char* const environment = std::getenv("CYCLONEDDS_URI");
  return environment != nullptr ? "the environment, CYCLONEDDS_URI=" + std::string{environment} : "";
}

DdsTelemetry::Parameters dds_parameters(const EcuConfig& config) {
  return {std::uint32_t(config.dds.domain), std::uint32_t(config.drive_id), dds_configuration(config),
          dds_configuration_source(config)};
}

}  // namespace

Ecu::Ecu(const EcuConfig& config)
    : config_{config},
      crossings_{config.drive.drive.period_ns, config.realtime.wake_every_periods},
      power_stage_{power_stage_parameters(config), config.drive.load.parameters()},
      controller_{make_controller(config.drive)},
      drive_{config.drive.drive, *controller_},
      bus_{make_can_bus(config.can.bus)},
      dds_{dds_parameters(config)},
      control_{config.realtime, config.drive.drive.period_ns, power_stage_.io(), drive_, crossings_},
      receive_{*bus_, crossings_},
      transmit_{*bus_, crossings_},
      watchdog_{config.realtime.watchdog_ns, crossings_} {}

Ecu::~Ecu() {
  stop();
}

void Ecu::start() {
  const RightsReport rights = control_.start();
  judge_rights(rights.refusals);
  TelemetryThread::Parameters parameters = telemetry_parameters(config_);
  parameters.real_time_scheduling = rights.fifo_scheduling;
  parameters.memory_locked = rights.memory_locked;
  telemetry_ = std::make_unique<TelemetryThread>(parameters, dds_, crossings_);
  telemetry_->start();
  watchdog_.start();
  receive_.start();
  transmit_.start();
  spdlog::info("drive {} on {}, DDS domain {}: {} control periods of {} us every wake-up", config_.drive_id,
               config_.can.bus, config_.dds.domain, config_.realtime.wake_every_periods,
               double(config_.drive.drive.period_ns) * 1e-3);
}

void Ecu::judge_rights(const std::vector<std::string>& refusals) const {
  if (!refusals.empty() && config_.realtime.required) {
    throw std::runtime_error(fmt::format("realtime.required is set, and not everything is granted: {}",
                                         fmt::join(refusals, "; ")));
  }
  for (const std::string& sentence : refusals) spdlog::warn("real time: {}", sentence);
}

void Ecu::stop() {
  crossings_.shutdown.store(true, std::memory_order_release);
  control_.join();
  // Should the control thread never have started, the others still have to leave.
  crossings_.stopped.store(true, std::memory_order_release);
  transmit_.join();
  receive_.join();
  watchdog_.join();
  if (telemetry_) telemetry_->join();
}

void Ecu::print_report(std::FILE* out) const {
  if (!telemetry_) return;
  const TelemetryThread::Totals& totals = telemetry_->totals();
  const LatencySummary latency = totals.latency.summary();
  const LatencySummary body = totals.body.summary();
  const auto us = [](std::int64_t ns) { return double(ns) * 1e-3; };
  const auto row = [&](const char* name, const LatencySummary& s) {
    fmt::print(out, "  {:<18} p50 {:>8.1f}  p99 {:>8.1f}  max {:>8.1f} us\n", name, us(s.p50_ns),
               us(s.p99_ns), us(s.max_ns));
  };
  fmt::print(out, "control periods {} run, {} missed in {} overruns\n", totals.last.periods,
             totals.last.periods_skipped, totals.last.overruns);
  row("wake-up latency", latency);
  row("work per wake-up", body);
  if (const std::uint64_t lost = crossings_.wakes.dropped(); lost > 0) {
    fmt::print(out, "  of {} wake-ups latency and work are not in these figures: nobody fetched them\n",
               lost);
  }
  print_commands(out);
  print_can(out);
  print_dds(out);
}

void Ecu::print_commands(std::FILE* out) const {
  fmt::print(out, "commands {} accepted, {} rejected\n", crossings_.commands_accepted.load(),
             crossings_.commands_rejected.load());
  for (std::size_t i = 0; i < frame_verdict_count; ++i) {
    const auto verdict = static_cast<FrameVerdict>(i);
    const std::uint64_t count = receive_.receiver().count(verdict);
    if (rejected(verdict) && count > 0) fmt::print(out, "  {:<18} {}\n", to_string(verdict), count);
  }
}

void Ecu::print_can(std::FILE* out) const {
  const CanBusStats stats = bus_->stats();
  fmt::print(out, "CAN {} sent, {} not sent, {} received; {} lost and {} unreadable on reception\n",
             stats.sent, stats.send_dropped, stats.received, stats.receive_overflow, stats.receive_malformed);
  if (stats.error_frames + stats.reopened > 0) {
    fmt::print(out, "  {} error frames, {} of them bus-off; interface came back {} times\n",
               stats.error_frames, stats.bus_off, stats.reopened);
  }
  if (transmit_.clamped() > 0) {
    fmt::print(out, "  {} status frames held a value beyond its signal's range\n", transmit_.clamped());
  }
}

void Ecu::print_dds(std::FILE* out) const {
  const DdsTelemetryCounts counts = dds_.counts();
  fmt::print(out, "telemetry {} published, {} periods dropped\n", counts.written,
             crossings_.telemetry.dropped());
  if (counts.refused > 0) {
    fmt::print(out, "  {} samples not published: a value was no finite number\n", counts.refused);
  }
  if (counts.failed > 0) fmt::print(out, "  {} samples not taken by DDS\n", counts.failed);
  if (const std::uint32_t readers = dds_.incompatible_readers(); readers > 0) {
    fmt::print(out, "  {} readers got nothing: they ask for a quality of service that is not offered\n",
               readers);
  }
}

}  // namespace sextant::ecu
