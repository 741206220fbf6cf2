#include "ecu/ecu.hpp"

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "ecu/telemetry/dds_settings.hpp"
#include "ecu/threads/watchdog_rights.hpp"
#include "ecu/timing/timing_report.hpp"
#include "ecu/unit/run_report.hpp"
#include "sextant/comms/can_codec.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {
namespace {

using namespace std::chrono_literals;

bool is_hard(const RealtimeParameters& realtime) {
  return realtime.wake_every_periods == 1;
}

/// SCHED_FIFO priority of the control thread in hard real time; 0 without.
int control_priority(const EcuConfig& config) {
  const RealtimeParameters& realtime = config.realtime;
  return is_hard(realtime) && realtime.policy == SchedulingPolicy::fifo ? realtime.priority : 0;
}

int highest_control_priority(const std::vector<EcuConfig>& configs) {
  int highest = 0;
  for (const EcuConfig& config : configs) highest = std::max(highest, control_priority(config));
  return highest;
}

/// Below the control threads and above all that is not real time; 0 without SCHED_FIFO.
int receive_priority(const std::vector<EcuConfig>& configs) {
  int lowest = 0;
  for (const EcuConfig& config : configs) {
    const int control = control_priority(config);
    if (control > 0) lowest = lowest == 0 ? control : std::min(lowest, control);
  }
  return lowest > 0 ? std::max(1, lowest - 10) : 0;
}

std::vector<CanIdentifier> identifiers(const std::vector<EcuConfig>& configs) {
  std::vector<CanIdentifier> wanted;
  for (const EcuConfig& config : configs) {
    const auto own = drive_identifiers(config.can.identifier_offset);
    wanted.insert(wanted.end(), own.begin(), own.end());
  }
  return wanted;
}

/// The configuration must outlive the drives.
std::vector<std::unique_ptr<LiveDrive>> make_drives(const DrivesConfig& config, CanBus& bus,
                                                    const LiveDriveOptions& options, const LoadDrives& load) {
  std::vector<std::unique_ptr<LiveDrive>> drives;
  for (std::size_t k = 0; k < config.drives.size(); ++k) {
    LiveDriveOptions own = options;
    own.record_cycles = config.file_of(options.record_cycles, k);
    own.fault_socket = config.file_of(options.fault_socket, k);
    own.set_socket = config.file_of(options.set_socket, k);
    own.load = load_of(load, k, config);
    if (config.drives.size() > 1) {
      own.thread = fmt::format("sextant-ctrl-{}", k + 1);
      own.prefix = fmt::format("drive {}: ", config.drives[k].drive_id);
    }
    drives.push_back(std::make_unique<LiveDrive>(config.drives[k], bus, own));
  }
  return drives;
}

/// Of the first drive: domain and configuration are those of the process.
TelemetryProcess::Parameters publisher_parameters(const EcuConfig& config) {
  const DdsSettings settings = dds_settings(config.dds, std::getenv("CYCLONEDDS_URI"));
  return {.domain_id = std::uint32_t(config.dds.domain),
          .configuration = settings.configuration,
          .configuration_source = settings.source};
}

std::vector<TelemetryConnection> connections_of(const std::vector<std::unique_ptr<LiveDrive>>& drives) {
  std::vector<TelemetryConnection> connections;
  connections.reserve(drives.size());
  for (const std::unique_ptr<LiveDrive>& drive : drives)
    connections.emplace_back(std::uint32_t(drive->unit().config().drive_id), drive->sender());
  return connections;
}

std::vector<DriveUnit*> units_of(const std::vector<std::unique_ptr<LiveDrive>>& drives) {
  std::vector<DriveUnit*> units;
  units.reserve(drives.size());
  for (const std::unique_ptr<LiveDrive>& drive : drives) units.push_back(&drive->unit());
  return units;
}

std::vector<ReceiveTask*> receive_tasks(const std::vector<std::unique_ptr<LiveDrive>>& drives) {
  std::vector<ReceiveTask*> tasks;
  tasks.reserve(drives.size());
  for (const std::unique_ptr<LiveDrive>& drive : drives) tasks.push_back(&drive->unit().receive());
  return tasks;
}

}  // namespace

Ecu::Ecu(const DrivesConfig& config, const LiveDriveOptions& options, const LoadDrives& load)
    : config_{config},
      processor_latency_{
          std::ranges::any_of(config.drives, [](const EcuConfig& drive) { return is_hard(drive.realtime); })},
      bus_{make_can_bus(bus_name(), identifiers(config.drives))},
      drives_{make_drives(config_, *bus_, options, load)},
      publisher_{publisher_parameters(config_.drives.front()), connections_of(drives_)},
      reaction_{config.on_fault, units_of(drives_)},
      receive_{*bus_, receive_tasks(drives_), is_over_, receive_priority(config.drives)},
      bus_watch_{*bus_} {}

Ecu::~Ecu() {
  stop();
}

void Ecu::start() {
  require_lone_drives();
  each([](LiveDrive& drive) { drive.prepare(); });
  start_threads();
  each([this](LiveDrive& drive) {
    const EcuConfig& config = drive.unit().config();
    spdlog::info(
        "drive {} on {} from identifier {:#x}, DDS domain {}: {} control periods of {} us every wake-up",
        config.drive_id, bus_name(), command_id(config.can.identifier_offset), config.dds.domain,
        config.realtime.wake_every_periods, double(config.drive.drive.period_ns) * 1e-3);
  });
}

void Ecu::start_threads() {
  const bool is_recorded =
      std::ranges::any_of(drives_, [](const auto& drive) { return drive->unit().cycles() != nullptr; });
  if (is_recorded) {
    cycles_.start({.poll = [this] {
      each([](LiveDrive& drive) { drive.write_cycles(); });
      return 20ms;
    }});
  }
  each([](LiveDrive& drive) { drive.go(); });
  telemetry_.start({.poll =
                        [this] {
                          each([](LiveDrive& drive) { drive.telemetry().poll(now_ns()); });
                          publisher_.poll(now_ns());
                          return std::chrono::milliseconds{TelemetryTask::poll_every_ms};
                        },
                    .end = [this] { each([](LiveDrive& drive) { drive.telemetry().finish(); }); }});
  watchdog_.start({.begin = [this] { request_watchdog_priority(highest_control_priority(config_.drives)); },
                   .poll =
                       [this] {
                         each([](LiveDrive& drive) { drive.unit().watchdog().poll(now_ns()); });
                         reaction_.poll(now_ns());
                         return std::chrono::nanoseconds{WatchdogTask::poll_every_ns};
                       }});
  // After the first measurement, so that each change is logged once.
  link_.start({.begin = [] { std::this_thread::sleep_for(20ms); },
               .poll =
                   [this] {
                     poll_links();
                     return 20ms;
                   }});
  housekeeping_.start({.poll = [this] {
    each([](LiveDrive& drive) { drive.housekeeping().poll(); });
    return std::chrono::milliseconds{HousekeepingTask::poll_every_ms};
  }});
  start_transmission();  // before a command can arrive
  receive_.start();
}

void Ecu::start_transmission() {
  // The age of the last status frame counts from here, also where the thread never runs.
  each([](LiveDrive& drive) { drive.unit().transmit().start(now_ns()); });
  transmit_.start(
      {.poll = [this] { return transmit(); },
       .end = [this] { each([](LiveDrive& drive) { drive.unit().transmit().send_last(now_ns()); }); }});
}

std::chrono::nanoseconds Ecu::transmit() {
  std::int64_t until_ns = std::numeric_limits<std::int64_t>::max();
  each([&](LiveDrive& drive) { until_ns = std::min(until_ns, drive.unit().transmit().poll(now_ns())); });
  const std::string trouble = bus_watch_.poll(now_ns());
  if (!trouble.empty()) spdlog::warn("CAN: {}", trouble);
  return std::chrono::nanoseconds{until_ns - now_ns()};
}

/// The drive's reaction does not depend on it.
void Ecu::poll_links() {
  bool must_end = false;
  each([&](LiveDrive& drive) { must_end |= drive.poll_link(); });
  must_end |= reaction_.has_ended();
  if (!must_end || is_asked_to_end_) return;
  is_asked_to_end_ = true;
  // main handles the signal like one from outside.
  kill(getpid(), SIGTERM);
}

void Ecu::require_lone_drives() {
  constexpr std::int64_t listen_ns = 200'000'000;  // twenty of its MCU_TorqueStatus
  CanFrame frame;
  const std::int64_t end_ns = now_ns() + listen_ns;
  for (std::int64_t left_ns = listen_ns; left_ns > 0; left_ns = end_ns - now_ns()) {
    const CanReceive result = bus_->receive(frame, std::chrono::nanoseconds{left_ns});
    if (result == CanReceive::down || result == CanReceive::error) return;
    if (result != CanReceive::got) continue;
    each([&](LiveDrive& drive) {
      DriveUnit& unit = drive.unit();
      (void)unit.receive().on_frame(frame);
      if (unit.shared().other_drive_ns.load(std::memory_order_relaxed) == 0) return;
      throw std::runtime_error(fmt::format(
          "another drive sends MCU_TorqueStatus on {} with this drive's identifiers: give each drive "
          "its own can.identifier_offset (here {}) or a bus of its own",
          bus_name(), unit.config().can.identifier_offset.value));
    });
  }
}

void Ecu::stop() {
  each([](LiveDrive& drive) { drive.unit().shut_down(); });
  each([](LiveDrive& drive) { drive.join(); });
  is_over_.store(true, std::memory_order_release);
  transmit_.join();
  receive_.join();
  watchdog_.join();
  link_.join();
  housekeeping_.join();
  telemetry_.join();
  publisher_.leave();  // once no thread polls it
  // Last: a disk that does not answer keeps nothing else.
  cycles_are_over_.store(true, std::memory_order_release);
  cycles_.join();
  each([](LiveDrive& drive) { drive.close(); });
}

std::string Ecu::problem() const {
  if (reaction_.has_ended()) return reaction_.problem();
  for (const std::unique_ptr<LiveDrive>& drive : drives_) {
    if (std::string problem = drive->problem(); !problem.empty()) return problem;
  }
  return {};
}

void Ecu::write_timing(const std::string& file) const {
  for (std::size_t k = 0; k < drives_.size(); ++k)
    ecu::write_timing(config_.file_of(file, k), drives_[k]->timing(), receive_.hand_over());
}

void Ecu::print_report(std::FILE* out) const {
  std::uint64_t clamped = 0;
  for (const std::unique_ptr<LiveDrive>& drive : drives_) {
    if (drives_.size() > 1) fmt::print(out, "drive {}\n", drive->unit().config().drive_id);
    drive->print_timing_and_commands(out);
    clamped += drive->unit().transmit().clamped();
  }
  print_can(out, bus_->stats(), clamped);
  for (std::size_t k = 0; k < drives_.size(); ++k) {
    if (drives_.size() > 1) fmt::print(out, "drive {}\n", drives_[k]->unit().config().drive_id);
    drives_[k]->print_telemetry(out, publisher_.counts(k));
  }
  if (publisher_.restarts() > 0)
    fmt::print(out, "sextant-telemetry was restarted {} times\n", publisher_.restarts());
}

}  // namespace sextant::ecu
