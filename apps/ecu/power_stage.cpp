#include "ecu/power_stage.hpp"

#include <stdexcept>

#include <fmt/format.h>

#include "common/network_report.hpp"

namespace sextant::ecu {
namespace {

/// The load's profiles begin at the first period, not at time zero of CLOCK_MONOTONIC.
SimulatedPowerStage::Parameters in_this_process(const EcuConfig& config, bool takes_faults) {
  SimulatedPowerStage::Parameters p = config.drive.plant;
  p.io.load_origin_ns.reset();
  p.io.takes_faults = takes_faults;
  return p;
}

const char* sentence(PowerStage::Plant plant) {
  switch (plant) {
    case PowerStage::Plant::answers:
      return "the plant answers; a fault reset takes the drive out of FAULT";
    case PowerStage::Plant::unacknowledged:
      return "the plant does not acknowledge the drive's patterns; the drive goes to FAULT "
             "(MEASUREMENT_INVALID)";
    case PowerStage::Plant::timed_out:
    case PowerStage::Plant::unknown:
      break;
  }
  return "the plant has timed out; the drive goes to FAULT (MEASUREMENT_INVALID) with its gates off";
}

}  // namespace

PowerStage::PowerStage(const EcuConfig& config, const std::string& fault_socket) {
  if (!fault_socket.empty() && config.power_stage != PowerStageKind::simulated) {
    throw std::runtime_error{
        "--fault-socket: the plant is in another process; give the option to its sextant-plant"};
  }
  switch (config.power_stage) {
    case PowerStageKind::simulated:
      simulate(config, fault_socket);
      break;
    case PowerStageKind::shared_memory:
      join_shared_memory(config);
      break;
    case PowerStageKind::udp:
      udp_ = std::make_unique<UdpDriveIo>(config.hil, config.drive.drive.period_ns);
      link_name_ = config.hil.udp_peer;
      io_ = udp_.get();
      break;
  }
}

void PowerStage::simulate(const EcuConfig& config, const std::string& fault_socket) {
  simulated_ = std::make_unique<LivePowerStage>(in_this_process(config, !fault_socket.empty()),
                                                config.drive.load.parameters());
  io_ = &simulated_->io();
  if (fault_socket.empty()) return;
  faults_ = std::make_unique<FaultInjection>(fault_socket, simulated_->io(), config.drive.plant.io.fault);
  io_ = &faults_->io();
}

void PowerStage::join_shared_memory(const EcuConfig& config) {
  link_ = std::make_unique<SharedMemoryLink>(config.hil, LinkRole::drive, config.drive.drive.period_ns);
  link_name_ = config.hil.link;
  if (config.hil.pacing == Pacing::lockstep) {
    lockstep_ = std::make_unique<LockstepDriveIo>(*link_, config.hil.lockstep_timeout_ns);
    io_ = lockstep_.get();
    return;
  }
  shared_memory_ = std::make_unique<SharedMemoryDriveIo>(
      *link_, assembler_parameters(config.hil, config.drive.drive.period_ns));
  io_ = shared_memory_.get();
}

void PowerStage::inhibit_gates() noexcept {
  if (shared_memory_) shared_memory_->inhibit_gates();
  if (udp_) udp_->inhibit_gates();
}

void PowerStage::announce_end() noexcept {
  if (link_) link_->announce_end();
  if (udp_) udp_->announce_end();
}

std::string PowerStage::state_change() {
  if (!shared_memory_ && !udp_) return {};
  const LinkState& state = shared_memory_ ? shared_memory_->state() : udp_->state();
  const Plant plant = state.timed_out()        ? Plant::timed_out
                      : state.unacknowledged() ? Plant::unacknowledged
                                               : Plant::answers;
  const std::string link = "hil " + link_name_ + ": ";
  const bool refused = reported_refusals_ != state.refusals();
  if (reported_ != plant) {
    const bool never_came = reported_ == Plant::unknown && plant == Plant::timed_out;
    reported_ = plant;
    return link + (never_came ? "no plant; the drive waits in INIT with its gates off" : sentence(plant));
  }
  reported_refusals_ = state.refusals();
  if (!refused) return {};
  return link +
         "the plant keeps its gates off against the drive's pattern; the drive goes to FAULT "
         "(MEASUREMENT_INVALID) with its gates off";
}

std::string PowerStage::problem() const {
  if (!lockstep_ || !lockstep_->lost()) return {};
  const char* const what = lockstep_->joined()      ? "ended or timed out"
                           : lockstep_->was_there() ? "was started, and ended or timed out"
                                                    : "was not started within hil.lockstep_timeout_ms";
  return "hil.link: the plant on \"" + link_name_ + "\" " + what +
         "; start sextant-plant with hil.pacing=lockstep";
}

void PowerStage::print_report(std::FILE* out) const {
  if (!shared_memory_ && !udp_) return;
  const MeasurementAssembler::Counters& c = shared_memory_ ? shared_memory_->counters() : udp_->counters();
  fmt::print(out, "plant {} measurements received, {} missing, {} too many at once\n", c.records, c.missing,
             c.overfull);
  fmt::print(out, "  late {} times, timed out {} times, restarted {} times\n", c.late, c.timeouts,
             c.restarts);
  if (c.unacknowledged + c.refused > 0) {
    fmt::print(out, "  acknowledged no pattern {} times, kept its gates off against {} patterns\n",
               c.unacknowledged, c.refused);
  }
  if (udp_) print_network(out, udp_->network(), udp_->unsent());
}

}  // namespace sextant::ecu
