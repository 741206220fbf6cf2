#include "sextant/virtual_time/virtual_vehicle.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace sextant {
namespace {

e2e::Data payload_of(const CanFrame& frame) {
  e2e::Data data{};
  std::copy_n(frame.data.begin(), data.size(), data.begin());
  return data;
}

}  // namespace

VirtualVehicle::VirtualVehicle(const Parameters& parameters, const VirtualClock& clock, VirtualCanBus& bus,
                               Torque torque, std::int64_t duration_ns)
    : parameters_{parameters},
      clock_{clock},
      bus_{bus},
      torque_{std::move(torque)},
      duration_ns_{duration_ns},
      next_ns_{parameters.first_ns},
      phase_{parameters.hand_shake ? Phase::waiting : Phase::driving},
      counter_{parameters.first_counter},
      checker_{torque_status_data_id(parameters.identifier_offset)} {
  if (const char* problem = parameters.validate()) throw std::invalid_argument{problem};
  bus_.listen([this](const CanFrame& frame) { hear(frame); });
}

VirtualParty VirtualVehicle::party() {
  return {.next_due_ns = [this] { return phase_ == Phase::done ? never_ns : next_ns_; },
          .act = [this] { act(); }};
}

void VirtualVehicle::act() {
  choose_phase();
  next_ns_ += parameters_.period_ns;
  switch (phase_) {
    case Phase::waiting:
      return send({.torque_limit = parameters_.torque_limit});
    case Phase::resetting:
      return send({.torque_limit = parameters_.torque_limit, .fault_reset = true});
    case Phase::driving:
      return send({.torque = torque_(clock_.now_ns() - enabled_ns_.value_or(clock_.now_ns())),
                   .torque_limit = parameters_.torque_limit,
                   .enable = true});
    case Phase::closing:
      ++closing_sent_;
      return send({.torque_limit = parameters_.torque_limit});
    case Phase::done:
      return;
  }
}

void VirtualVehicle::choose_phase() {
  const std::int64_t now = clock_.now_ns();
  const bool tripped = parameters_.clear_faults && drive_has_tripped();
  if (phase_ == Phase::waiting && drive_is_ready() && now >= parameters_.enable_from_ns)
    phase_ = Phase::driving;
  if (phase_ == Phase::resetting && !drive_has_tripped()) phase_ = Phase::waiting;
  if ((phase_ == Phase::waiting || phase_ == Phase::driving) && tripped) phase_ = Phase::resetting;
  if (phase_ == Phase::driving && !enabled_ns_) enabled_ns_ = now;
  const bool over = enabled_ns_ && now - *enabled_ns_ > duration_ns_;
  if (over && phase_ != Phase::closing && phase_ != Phase::done) phase_ = Phase::closing;
  if (phase_ == Phase::closing && closing_sent_ >= parameters_.closing_frames) phase_ = Phase::done;
}

void VirtualVehicle::send(const TorqueCommand<double>& command) {
  if (paused_) return;
  CanFrame frame = encode(command).frame;
  frame.id = command_id(parameters_.identifier_offset);
  e2e::Data data = payload_of(frame);
  if (tamper_) tamper_(data);
  e2e::protect(command_data_id(parameters_.identifier_offset), counter_, data);
  std::ranges::copy(data, frame.data.begin());
  if (!frozen_) skip_counters(1);
  bus_.put(frame);
}

void VirtualVehicle::skip_counters(unsigned n) noexcept {
  counter_ = static_cast<std::uint8_t>((counter_ + n) % e2e::counter_modulus);
}

void VirtualVehicle::hear(const CanFrame& frame) {
  const std::optional<TorqueStatus> status = decode_torque_status(frame, parameters_.identifier_offset);
  if (status && usable(checker_.check(payload_of(frame)))) status_ = status;
}

bool VirtualVehicle::drive_is_ready() const noexcept {
  return status_ && status_->state == DriveState::ready && !status_->lockout;
}

bool VirtualVehicle::drive_has_tripped() const noexcept {
  return status_ && status_->state == DriveState::fault;
}

}  // namespace sextant
