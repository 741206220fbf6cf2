#include "ecu/ecu.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "common/process_setup.hpp"
#include "ecu/run_report.hpp"
#include "ecu/telemetry/dds_settings.hpp"
#include "ecu/timing/timing_report.hpp"
#include "sextant/comms/can_codec.hpp"
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

TelemetryProcess::Parameters publisher_parameters(const EcuConfig& config) {
  const DdsSettings settings = dds_settings(config.dds, std::getenv("CYCLONEDDS_URI"));
  return {.domain_id = std::uint32_t(config.dds.domain),
          .drive_id = std::uint32_t(config.drive_id),
          .configuration = settings.configuration,
          .configuration_source = settings.source};
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

}  // namespace

Ecu::Ecu(const EcuConfig& config, const std::string& record_cycles, const std::string& fault_socket)
    : config_{config},
      processor_latency_{is_hard(config.realtime)},
      shared_{config.drive.drive.period_ns, config.realtime.wake_every_periods, config.realtime.watchdog_ns},
      power_stage_{config, fault_socket},
      drive_{config.drive},
      bus_{make_can_bus(config.can.bus, drive_identifiers(config.can.identifier_offset))},
      publisher_{publisher_parameters(config)},
      control_{config.realtime, config.drive.drive.period_ns, recorded_io(record_cycles), drive_.drive(),
               shared_},
      receive_{*bus_, shared_, config.can.identifier_offset, receive_priority(config.realtime)},
      transmit_{*bus_, shared_, config.can.identifier_offset,
                [](const std::string& sentence) { spdlog::warn("CAN: {}", sentence); }},
      watchdog_{shared_, [this] { power_stage_.inhibit_gates(); }, control_priority(config.realtime)},
      link_{power_stage_, shared_},
      housekeeping_{shared_, [](const std::string& sentence) { spdlog::warn("drive: {}", sentence); }},
      telemetry_{telemetry_parameters(config), publisher_.sender(), shared_,
                 [this](std::int64_t now_ns) { publisher_.poll(now_ns); },
                 [](const std::string& sentence) { spdlog::warn("drive: {}", sentence); }} {}

DriveIo<double>& Ecu::recorded_io(const std::string& record_cycles) {
  if (record_cycles.empty()) return power_stage_.io();
  cycles_.emplace(record_cycles, config_, power_stage_.io());
  cycle_thread_.emplace(*cycles_,
                        [](const std::string& sentence) { spdlog::error("recording: {}", sentence); });
  shared_.cycles = &cycles_->recorder();
  return cycles_->recorder();
}

void Ecu::serve_parameters(const std::string& socket, ParameterChanges::Load load) {
  changes_.emplace(config_, std::move(load), shared_);
  parameters_.emplace(socket, *changes_);
  link_.serve(*parameters_);
}

Ecu::~Ecu() {
  stop();
}

void Ecu::start() {
  require_lone_drive();
  const RightsReport rights = control_.start();
  check_rights(config_.realtime, rights);
  warn_of_unbounded_execution();
  if (cycles_) cycles_->open();
  if (cycle_thread_) cycle_thread_->start();
  control_.go();
  telemetry_.start(rights);
  watchdog_.start();
  link_.start();
  housekeeping_.start();
  transmit_.start();  // before a command can arrive
  receive_.start();
  spdlog::info(
      "drive {} on {} from identifier {:#x}, DDS domain {}: {} control periods of {} us every wake-up",
      config_.drive_id, config_.can.bus, command_id(config_.can.identifier_offset), config_.dds.domain,
      config_.realtime.wake_every_periods, double(config_.drive.drive.period_ns) * 1e-3);
}

void Ecu::require_lone_drive() {
  constexpr std::int64_t listen_ns = 200'000'000;  // twenty of its MCU_TorqueStatus
  CanFrame frame;
  const std::int64_t end_ns = now_ns() + listen_ns;
  for (std::int64_t left_ns = listen_ns; left_ns > 0; left_ns = end_ns - now_ns()) {
    const CanReceive result = bus_->receive(frame, std::chrono::nanoseconds{left_ns});
    if (result == CanReceive::got) (void)receive_.task().on_frame(frame);
    if (shared_.other_drive_ns.load(std::memory_order_relaxed) != 0) {
      throw std::runtime_error(fmt::format(
          "another drive sends MCU_TorqueStatus on {} with this drive's identifiers: give each drive "
          "its own can.identifier_offset (here {}) or a bus of its own",
          config_.can.bus, config_.can.identifier_offset.value));
    }
    if (result == CanReceive::down || result == CanReceive::error) return;
  }
}

void Ecu::warn_of_unbounded_execution() const {
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
  shared_.shutdown.store(true, std::memory_order_release);
  control_.join();
  power_stage_.announce_end();
  // The other threads also end where the control thread was never started.
  shared_.stopped.store(true, std::memory_order_release);
  transmit_.join();
  receive_.join();
  watchdog_.join();
  link_.join();
  housekeeping_.join();
  telemetry_.join();
  publisher_.leave();
  // Last: a disk that does not answer keeps nothing else.
  if (cycle_thread_) cycle_thread_->join();
  if (cycles_) cycles_->close();
}

std::string Ecu::problem() const {
  if (std::string problem = power_stage_.problem(); !problem.empty()) return problem;
  return cycles_ ? cycles_->failure() : std::string{};
}

void Ecu::write_timing(const std::string& file) const {
  ecu::write_timing(file, telemetry_.task().timing(), receive_.hand_over());
}

void Ecu::print_report(std::FILE* out) const {
  print_timing(out, telemetry_.task().timing());
  if (const std::uint64_t lost = shared_.wakes.dropped(); lost > 0) {
    fmt::print(out,
               "  of {} wake-ups latency and execution time are not in these figures: the ring was full\n",
               lost);
  }
  power_stage_.print_report(out);
  print_commands(out, receive_.task().receiver(), config_.can.identifier_offset);
  print_can(out, bus_->stats(), transmit_.task().clamped());
  print_dds(out);
  if (cycles_) cycles_->print_report(out);
}

void Ecu::print_dds(std::FILE* out) const {
  const CountsMessage counts = publisher_.counts();
  fmt::print(out, "telemetry {} published, {} periods dropped\n", counts.written,
             shared_.telemetry.dropped());
  if (const std::uint64_t stalls = shared_.telemetry_stalls.load(); stalls > 0) {
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
  if (const std::uint64_t lost = publisher_.sender().dropped(); lost > 0) {
    fmt::print(out, "  {} samples not published: sextant-telemetry did not receive them\n", lost);
  }
  if (publisher_.restarts() > 0) {
    fmt::print(out, "  sextant-telemetry was restarted {} times\n", publisher_.restarts());
  }
}

}  // namespace sextant::ecu
