#include "plant/plant.hpp"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "common/network_report.hpp"
#include "common/process_setup.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/run/scenario_mark.hpp"

namespace sextant::plant {
namespace {

/// In real time the link itself delays a pattern by one period.
SimulatedPowerStage::Parameters stage_parameters(const PlantConfig& config, bool takes_faults) {
  SimulatedPowerStage::Parameters p = config.plant;
  p.io.takes_faults = takes_faults;
  if (config.hil.pacing == Pacing::real_time) p.io.actuation_delay_periods = 0;
  return p;
}

GateGuard::Parameters guard_parameters(const PlantConfig& config) {
  return {config.period_ns, config.plant.io.hold_periods, config.hil.pattern_timeout_ns};
}

double ms(std::int64_t ns) {
  return double(ns) * 1e-6;
}

}  // namespace

Plant::Plant(const PlantConfig& config, const std::string& fault_socket, const Scenario* scenario)
    : config_{config},
      awake_{config.hil.pacing == Pacing::real_time},
      task_{{.period_ns = config.period_ns, .wake_every_periods = 1}, config.realtime.wait} {
  const SimulatedPowerStage::Parameters parameters = stage_parameters(config, !fault_socket.empty());
  if (scenario != nullptr) {
    if (config.hil.pacing != Pacing::lockstep)
      throw std::runtime_error{
          "--scenario needs hil.pacing \"lockstep\": a plant in real time does not know its drive's time"};
    scenario_ = scenario_mark(*scenario);
    observed_ = std::make_unique<ObservedPowerStage>(*scenario, parameters);
    observed_->start(nullptr, nullptr);
  } else {
    stage_ = std::make_unique<LivePowerStage>(parameters, config.load.parameters());
  }
  if (!fault_socket.empty())
    faults_ = std::make_unique<FaultInjection>(fault_socket, stage(), config.plant.io.fault);
  if (config.transport == PlantTransport::udp) {
    udp_end_ = std::make_unique<UdpPlantEnd>(config.hil, config.period_ns);
    udp_ = std::make_unique<PlantServer<UdpPlantEnd>>(guard_parameters(config), io(), *udp_end_);
    return;
  }
  link_ = std::make_unique<SharedMemoryLink>(config.hil, LinkRole::plant, config.period_ns);
  if (config.hil.pacing == Pacing::lockstep) {
    lockstep_ = std::make_unique<LockstepPlant>(*link_, io(), config.hil.lockstep_timeout_ns);
    if (observed_)
      lockstep_->observe([this](const DriveReport& report, std::int64_t t_ns, double omega_m) {
        observe(report, t_ns, omega_m);
      });
    return;
  }
  shared_memory_end_ = std::make_unique<SharedMemoryPlantEnd>(*link_);
  shared_memory_ = std::make_unique<PlantServer<SharedMemoryPlantEnd>>(guard_parameters(config), io(),
                                                                       *shared_memory_end_);
}

Plant::~Plant() {
  stop();
}

void Plant::start() {
  // The thread sleeps until its rights are checked, so that it does not starve the thread that checks them.
  thread_ = std::thread{[this] { run(rights_checked_.get_future()); }};
  try {
    const RightsReport report = rights_.get_future().get();
    check_rights(config_.realtime, report);
  } catch (...) {
    stop_.store(true, std::memory_order_release);
    rights_checked_.set_value();
    throw;
  }
  rights_checked_.set_value();
  if (lockstep_) {
    spdlog::info("plant on {}: in lockstep, waiting for a drive", meeting_point());
    return;
  }
  spdlog::info("plant on {}: a period of {} us", meeting_point(), double(config_.period_ns) * 1e-3);
}

std::string Plant::meeting_point() const {
  return udp_ ? "UDP " + config_.hil.udp_listen : "link " + config_.hil.link;
}

void Plant::run(std::future<void> rights_checked) {
  if (lockstep_) {
    rights_.set_value({});  // virtual time needs none
    rights_checked.wait();
    run_lockstep();
  } else {
    rights_.set_value(
        set_up_control_thread(config_.realtime, task_.schedule().parameters().wake_period_ns()));
    rights_checked.wait();
    udp_ ? run_real_time(*udp_) : run_real_time(*shared_memory_);
  }
}

void Plant::run_lockstep() {
  using Outcome = LockstepPlant::Outcome;
  Outcome outcome = Outcome::waiting;
  while (!stop_.load(std::memory_order_acquire) &&
         (outcome == Outcome::waiting || outcome == Outcome::stepped) && !plays_another_) {
    outcome = lockstep_->step();
    if (outcome == Outcome::stepped) joined_.store(true, std::memory_order_relaxed);
  }
  if (outcome == Outcome::lost) {
    problem_ = "hil.link: the drive on \"" + config_.hil.link +
               "\" ended or timed out; the gates are off: restart both sides";
  }
  ended_.store(true, std::memory_order_release);
}

void Plant::observe(const DriveReport& report, std::int64_t t_ns, double omega_m) {
  plays_scenario_ =
      report.scenario == scenario_ && report.begin_ns == ObservedPowerStage::begin_ns(config_.period_ns);
  plays_another_ = report.scenario != 0 && !plays_scenario_;
  if (plays_scenario_) observed_->period(to_telemetry(report, t_ns, omega_m));
}

std::string Plant::other_play() const {
  if (plays_scenario_) return {};
  const std::string drive = "the drive on \"" + config_.hil.link + "\" ";
  if (plays_another_)
    return drive + "plays another scenario, by its torque or length: give both programs the same file";
  return drive + "has played no scenario: start sextant-ecu --virtual-time --scenario with the same file";
}

template <class Server>
void Plant::run_real_time(Server& server) {
  task_.start();
  while (!stop_.load(std::memory_order_acquire)) {
    const WakeSchedule::Wake wake = task_.wait();
    const std::int64_t begin_ns = now_ns();
    server.step(wake.deadline_ns);
    execution_.record(now_ns() - begin_ns);
    latency_.record(wake.latency_ns);
    ++periods_;
  }
}

void Plant::stop() {
  stop_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

void Plant::log_events() {
  if (lockstep_) {
    log_join();
    return;
  }
  GateEvent event;
  while (events().pop(event)) log(event);
}

void Plant::log_join() {
  if (join_logged_ || !joined_.load(std::memory_order_relaxed)) return;
  join_logged_ = true;
  spdlog::info("plant on {}: a drive has joined the lockstep", meeting_point());
}

void Plant::log(const GateEvent& e) {
  if (e.cause == GateCause::following) {
    spdlog::info("gates follow the drive from {:.6f} s on", double(e.t_ns) * 1e-9);
    return;
  }
  if (e.off_since_ns == 0) {
    spdlog::info("gates are off as from the start: {}", to_string(e.cause));
    return;
  }
  const std::int64_t to_off_ns =
      e.last_pattern_ns == 0 ? 0 : std::max<std::int64_t>(0, e.off_since_ns - e.last_pattern_ns);
  longest_to_off_ns_ = std::max(longest_to_off_ns_, to_off_ns);
  spdlog::warn(
      "gates stay off since {:.6f} s: {}; last pattern at {:.6f} s, {:.3f} ms before, seen at {:.6f} s",
      double(e.off_since_ns) * 1e-9, to_string(e.cause), double(e.last_pattern_ns) * 1e-9, ms(to_off_ns),
      double(e.t_ns) * 1e-9);
}

void Plant::print_report(std::FILE* out) const {
  if (lockstep_) {
    print_lockstep(out);
  } else {
    print_real_time(out);
    if (udp_) print_network(out, udp_end_->network(), udp_end_->unsent());
  }
}

void Plant::print_lockstep(std::FILE* out) const {
  const double simulated_s = double(lockstep_->end_ns() - lockstep_->begin_ns()) * 1e-9;
  fmt::print(out, "plant periods {} in lockstep, {:.6f} s of virtual time\n", lockstep_->steps(),
             simulated_s);
}

void Plant::print_real_time(std::FILE* out) const {
  const auto us = [](std::int64_t ns) { return double(ns) * 1e-3; };
  const auto row = [&](const char* name, const LatencySummary& s) {
    fmt::print(out, "  {:<18} p50 {:>8.1f}  p99 {:>8.1f}  max {:>8.1f} us\n", name, us(s.p50_ns),
               us(s.p99_ns), us(s.max_ns));
  };
  const WakeSchedule::Counters& wakes = task_.schedule().counters();
  fmt::print(out, "plant periods {} run, {} missed in {} overruns\n", periods_, wakes.periods_missed,
             wakes.overruns);
  row("wake-up latency", latency_.summary());
  row("execution time", execution_.summary());
  const GateGuard::Counters& c = guard().counters();
  fmt::print(out, "patterns {} received of {} drives, {} missing, {} unreadable; {} periods held\n",
             c.commands, c.drives, c.missing, c.unreadable, c.held);
  fmt::print(
      out,
      "gates turned off: {} times for a late pattern, {} for a drive that timed out, {} by the enable line\n",
      c.late, c.timed_out, c.disabled);
  if (c.locked_out + c.outdated > 0) {
    fmt::print(out, "  kept off: {} times until the drive had shown gates off; {} patterns were outdated\n",
               c.locked_out, c.outdated);
  }
  fmt::print(out, "  at most {:.3f} ms after the last pattern of a drive that timed out or ended\n",
             ms(longest_to_off_ns_));
  if (const std::uint64_t count = udp_ ? udp_->implausible() : shared_memory_->implausible(); count > 0) {
    fmt::print(out, "  {} periods without a usable measurement: the integrator has failed\n", count);
  }
}

}  // namespace sextant::plant
