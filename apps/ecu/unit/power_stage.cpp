#include "ecu/unit/power_stage.hpp"

#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "common/network_report.hpp"
#include "sextant/hil/shared_memory_drive_io.hpp"
#include "sextant/hil/udp_drive_io.hpp"

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

PowerStage::PowerStage(const EcuConfig& config, const std::string& fault_socket,
                       const std::string& log_prefix) {
  switch (config.power_stage_kind()) {
    case PowerStageKind::simulated:
      simulate(config, fault_socket, log_prefix);
      break;
    case PowerStageKind::shared_memory:
      join_shared_memory(config);
      break;
    case PowerStageKind::udp:
      link_ = std::make_unique<UdpDriveIo>(config.hil, config.drive.drive.period_ns);
      name_ = config.hil.udp_peer;
      io_ = link_.get();
      break;
    case PowerStageKind::own:
      open_own(config);
      break;
  }
  supervised_ = dynamic_cast<SupervisedDriveIo<double>*>(io_);
}

void PowerStage::open_own(const EcuConfig& config) {
  own_ = config.own_power_stage().open();
  name_ = config.power_stage;
  io_ = own_.get();
}

void PowerStage::simulate(const EcuConfig& config, const std::string& fault_socket,
                          const std::string& log_prefix) {
  simulated_ = std::make_unique<LivePowerStage>(in_this_process(config, !fault_socket.empty()),
                                                config.drive.load.parameters());
  io_ = &simulated_->io();
  if (fault_socket.empty()) return;
  faults_ = std::make_unique<FaultInjection>(fault_socket, simulated_->io(), config.drive.plant.io.fault,
                                             log_prefix);
  io_ = &faults_->io();
}

void PowerStage::join_shared_memory(const EcuConfig& config) {
  const std::int32_t period_ns = config.drive.drive.period_ns;
  memory_ = std::make_unique<SharedMemoryLink>(config.hil, LinkRole::drive, period_ns);
  name_ = config.hil.link;
  if (config.hil.pacing == Pacing::lockstep) {
    auto lockstep = std::make_unique<LockstepDriveIo>(*memory_, config.hil.lockstep_timeout_ns);
    lockstep_ = lockstep.get();
    link_ = std::move(lockstep);
  } else {
    link_ = std::make_unique<SharedMemoryDriveIo>(*memory_, assembler_parameters(config.hil, period_ns));
  }
  io_ = link_.get();
}

void PowerStage::inhibit_gates() noexcept {
  if (supervised_ != nullptr) supervised_->inhibit_gates();
}

void PowerStage::announce_end() noexcept {
  if (supervised_ != nullptr) supervised_->announce_end();
}

std::string PowerStage::state_change() {
  const LinkState* const found = link_ ? link_->link_state() : nullptr;
  if (found == nullptr) return {};
  const LinkState& state = *found;
  const Plant plant = state.timed_out()        ? Plant::timed_out
                      : state.unacknowledged() ? Plant::unacknowledged
                                               : Plant::answers;
  const std::string link = "hil " + name_ + ": ";
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
  const char* const loss = supervised_ != nullptr ? supervised_->loss() : nullptr;
  if (loss == nullptr) return {};
  if (own_) return "power_stage: \"" + name_ + "\" " + loss;
  return "hil.link: the plant on \"" + name_ + "\" " + loss +
         "; start sextant-plant with hil.pacing=lockstep";
}

void PowerStage::print_report(std::FILE* out) const {
  const std::optional<LinkedDriveIo::Counts> counts = link_ ? link_->counts() : std::nullopt;
  if (!counts) return;
  const MeasurementAssembler::Counters& c = counts->measurements;
  fmt::print(out, "plant {} measurements received, {} missing, {} too many at once\n", c.records, c.missing,
             c.overfull);
  fmt::print(out, "  late {} times, timed out {} times, restarted {} times\n", c.late, c.timeouts,
             c.restarts);
  if (c.unacknowledged + c.refused > 0) {
    fmt::print(out, "  acknowledged no pattern {} times, kept its gates off against {} patterns\n",
               c.unacknowledged, c.refused);
  }
  if (counts->network) print_network(out, counts->network->received, counts->network->unsent);
}

}  // namespace sextant::ecu
