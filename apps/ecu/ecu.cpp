#include "ecu/ecu.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "ecu/timing_file.hpp"
#include "ecu/timing_report.hpp"
#include "sextant/config/make_controller.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {
namespace {

TelemetryThread::Parameters telemetry_parameters(const EcuConfig& config) {
  const double period_s = double(config.drive.drive.period_ns) * 1e-9;
  TelemetryThread::Parameters p;
  p.period_ns = config.drive.drive.period_ns;
  p.wake_every_periods = std::uint32_t(config.realtime.wake_every_periods);
  p.periods_per_sample =
      std::max(1U, std::uint32_t(std::lround(1.0 / (config.dds.telemetry_rate_hz * period_s))));
  p.timing = {config.realtime.gap_limit_ns,
              std::int64_t{config.drive.drive.period_ns} * config.realtime.wake_every_periods};
  p.wait = config.realtime.wait.mode;
  p.policy = config.realtime.policy;
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

bool is_hard(const RealtimeParameters& realtime) {
  return realtime.wake_every_periods == 1;
}

/// SCHED_FIFO priority of the control thread in hard real time; 0 without.
int control_priority(const RealtimeParameters& realtime) {
  return is_hard(realtime) && realtime.policy == SchedulingPolicy::fifo ? realtime.priority : 0;
}

/// Below the control thread and above all that is not real time; 0 without SCHED_FIFO.
int receive_priority(const RealtimeParameters& realtime) {
  const int control = control_priority(realtime);
  return control > 0 ? std::max(1, control - 10) : 0;
}

/// Before any thread is started: all but the control thread stay off its CPU.
EcuConfig apart(EcuConfig config) {
  if (const Grant grant = keep_off_cpu(config.realtime.cpu); !grant.granted) {
    spdlog::warn("real time: {}", grant.sentence);
  }
  return config;
}

}  // namespace

Ecu::Ecu(const EcuConfig& config)
    : config_{apart(config)},
      awake_{is_hard(config.realtime)},
      crossings_{config.drive.drive.period_ns, config.realtime.wake_every_periods},
      power_stage_{config},
      controller_{make_controller(config.drive)},
      drive_{config.drive.drive, *controller_},
      bus_{make_can_bus(config.can.bus)},
      dds_{dds_parameters(config)},
      control_{config.realtime, config.drive.drive.period_ns, power_stage_.io(), drive_, crossings_},
      receive_{*bus_, crossings_, receive_priority(config.realtime)},
      transmit_{*bus_, crossings_},
      watchdog_{config.realtime.watchdog_ns, crossings_, [this] { power_stage_.open_gates(); },
                control_priority(config.realtime)},
      monitor_{power_stage_, crossings_},
      housekeeping_{crossings_} {}

Ecu::~Ecu() {
  stop();
}

void Ecu::start() {
  const RightsReport rights = control_.start();
  require_rights(config_.realtime, rights);
  for (const std::string& sentence : rights.refusals) spdlog::warn("real time: {}", sentence);
  require_room_for_spinning(config_.realtime, rights);
  warn_of_unbounded_work();
  control_.go();
  TelemetryThread::Parameters parameters = telemetry_parameters(config_);
  parameters.real_time_scheduling = rights.real_time_scheduling;
  parameters.memory_locked = rights.memory_locked;
  telemetry_ = std::make_unique<TelemetryThread>(parameters, dds_, crossings_);
  telemetry_->start();
  watchdog_.start();
  monitor_.start();
  housekeeping_.start();
  receive_.start();
  transmit_.start();
  spdlog::info("drive {} on {}, DDS domain {}: {} control periods of {} us every wake-up", config_.drive_id,
               config_.can.bus, config_.dds.domain, config_.realtime.wake_every_periods,
               double(config_.drive.drive.period_ns) * 1e-3);
}

void Ecu::warn_of_unbounded_work() const {
  const IntegratorKind kind = config_.drive.plant.integrator;
  const bool unbounded = kind == IntegratorKind::cvode || kind == IntegratorKind::erk;
  if (config_.power_stage != PowerStageKind::simulated || config_.realtime.wake_every_periods > 1 ||
      !unbounded) {
    return;
  }
  spdlog::warn(
      "real time: plant.integrator = \"{}\" has no bound on its time; with realtime.wake_every_periods = 1 a "
      "long step misses periods: take \"fixed\"",
      kind == IntegratorKind::cvode ? "cvode" : "erk");
}

void Ecu::stop() {
  crossings_.shutdown.store(true, std::memory_order_release);
  control_.join();
  power_stage_.say_goodbye();
  // Should the control thread never have started, the others still have to leave.
  crossings_.stopped.store(true, std::memory_order_release);
  transmit_.join();
  receive_.join();
  watchdog_.join();
  monitor_.join();
  housekeeping_.join();
  if (telemetry_) telemetry_->join();
}

void Ecu::write_timing(const std::string& file) const {
  if (telemetry_) ecu::write_timing(file, telemetry_->timing(), receive_.hand_over());
}

void Ecu::print_report(std::FILE* out) const {
  if (!telemetry_) return;
  print_timing(out, telemetry_->timing());
  if (const std::uint64_t lost = crossings_.wakes.dropped(); lost > 0) {
    fmt::print(out, "  of {} wake-ups latency and work are not in these figures: nobody fetched them\n",
               lost);
  }
  power_stage_.print_report(out);
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
