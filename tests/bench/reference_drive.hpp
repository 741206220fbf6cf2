#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "bench/reference_dtc.hpp"
#include "sextant/core/drive_request.hpp"
#include "sextant/core/measurement.hpp"

namespace sextant::bench {

/// What `ReferenceDrive` answers: the vector number and every number that `Telemetry` has.
struct ReferenceRecord {
  std::int64_t t_ns;
  double torque_requested, torque_reference, torque;
  double psi_a, psi_b, psi;
  double i_a, i_b, i_c, u_dc, i_dc, omega_m;
  double motoring, regenerating;
  std::int32_t duration_ns;
  std::uint8_t vector, sector, state;
  bool lockout;
  std::uint64_t active, latched;
  std::uint8_t first_fault;
  std::uint32_t fault_total;
  std::int64_t command_received_ns;
  std::uint64_t command_sequence;
  std::uint32_t command_rejected;
  std::uint8_t command_counter;
};

/// One period of the whole drive as one would write it by hand, in one function without abstractions: the
/// yardstick for `Drive::step`. The same checks and the same arithmetic in the same order: protections,
/// torque capability, command supervision, state machine, DTC, DC-link current, telemetry record. Left out is
/// what happens without torque: magnetising, and the estimate while the gates are off.
class ReferenceDrive {
 public:
  void step(std::int64_t t_ns, const Measurement<double>& m, const DriveRequest<double>& request,
            ReferenceRecord& out) {
    const TorqueCommand<double>& command = request.command;

    std::uint64_t faults = request.external.bits();
    const bool usable = m.plausible && std::isfinite(m.i_abc.a) && std::isfinite(m.i_abc.b) &&
                        std::isfinite(m.i_abc.c) && std::isfinite(m.u_dc) && std::isfinite(m.omega_m);
    if (!usable) {
      faults |= 1U << 5U;
    } else {
      const double peak = std::max(std::max(std::abs(m.i_abc.a), std::abs(m.i_abc.b)), std::abs(m.i_abc.c));
      if (peak > over_current) faults |= 1U << 8U;
      if (m.u_dc > over_voltage) faults |= 1U << 9U;
    }

    const double over = (std::abs(m.omega_m) - base_speed) * inverse_range;
    const double motoring = over <= 0.0 ? torque_limit : over < 1.0 ? torque_limit * (1.0 - over) : 0.0;
    const double lowest = m.omega_m > 0.0 ? -torque_limit : -motoring;
    const double highest = m.omega_m < 0.0 ? torque_limit : motoring;

    const std::int64_t elapsed_ns = started_ ? std::max(t_ns - last_ns_, period_ns) : period_ns;
    last_ns_ = t_ns;
    started_ = true;
    const bool valid = command.e2e == E2eState::valid;
    const bool fresh = command.sequence != sequence_;
    const bool disabled = command.disables != disables_;
    const bool unseen_reset = command.resets != resets_;
    disables_ = command.disables;
    resets_ = command.resets;
    if (fresh) age_from_ns_ = std::min(command.received_ns, t_ns);
    sequence_ = command.sequence;
    const std::int64_t age_ns = t_ns - age_from_ns_;
    const bool lost = age_ns > lost_ns;
    bool reset = false;
    if (valid && disabled && !lost) {
      enable_ = false;
      blocked_ = 0;
      setpoint_ = 0.0;
      reset = unseen_reset;
      if (!unseen_reset) lockout_ = false;
    }
    if (valid && fresh && !lost) {
      if (!command.enable) {
        enable_ = false;
        blocked_ = 0;
        setpoint_ = 0.0;
        reset = reset || command.fault_reset;
        if (!command.fault_reset) lockout_ = false;
      } else if (std::abs(command.torque) <= torque_limit && command.torque_limit >= 0.0) {
        blocked_ = 0;
        enable_ = true;
        setpoint_ = std::clamp(command.torque, -command.torque_limit, command.torque_limit);
      } else {
        ++blocked_;
      }
    }
    if (fresh || command.out_of_range < out_of_range_) out_of_range_ = 0;
    blocked_ += command.out_of_range - out_of_range_;
    out_of_range_ = command.out_of_range;
    if (!valid || lost) lockout_ = true;
    std::uint32_t command_faults = 0;
    if (lost) command_faults |= 1U;
    if (command.e2e == E2eState::invalid) command_faults |= 2U;
    if (command.bus_off) command_faults |= 1U << 4U;
    if (blocked_ >= 3) command_faults |= 4U;
    const bool enable = enable_ && !disabled && !lockout_ && command_faults == 0;
    bool derated = false;
    double target = 0.0;
    double rate = torque_rate;
    if (!enable) {
      ramp_ = 0.0;
      ramping_to_zero_ = false;
    } else if (age_ns > timeout_ns || request.shutdown) {
      if (!ramping_to_zero_) zero_rate_ = std::abs(ramp_) * 100.0;
      ramping_to_zero_ = true;
      rate = std::max(zero_rate_, 1.0);
    } else {
      ramping_to_zero_ = false;
      target = std::clamp(setpoint_, lowest, highest);
      derated = target != setpoint_;
    }
    if (ramp_ != target) {
      const double largest = rate * double(elapsed_ns) * 1e-9;
      const double change = std::clamp(target - ramp_, -largest, largest);
      ramp_ = change == target - ramp_ ? target : ramp_ + change;
    }

    if (state_ >= 3 && state_ <= 5) faults |= command_faults;
    for (std::uint64_t left = faults & ~latched_; left != 0; left &= left - 1) {
      const auto fault = std::uint8_t(std::countr_zero(left));
      if (latched_ == 0) first_fault_ = fault;
      latched_ |= std::uint64_t{1} << fault;
      ++fault_total_;
    }
    const bool driving = state_ >= 3 && state_ <= 5;
    const std::uint8_t before = state_;
    if (state_ == 7 || (request.shutdown && (faults != 0 || ramp_ == 0.0 || !driving))) {
      state_ = 7;
    } else if (faults != 0) {
      state_ = 6;
    } else if (state_ == 0) {
      state_ = 1;
    } else if (state_ == 6) {
      state_ = reset ? 1 : 6;
    } else if (lockout_) {
      state_ = 1;
    } else if (!enable || state_ == 1) {
      state_ = 2;
    } else {
      state_ = derated ? 5 : 4;
    }
    if (state_ == 6) {
      lockout_ = true;
      setpoint_ = ramp_ = 0.0;
    }
    if (before == 6 && state_ == 1) latched_ = 0;

    const GateSegment& applied = m.applied.segments()[0];
    const unsigned upper = applied.state.upper_switches();
    const bool makes_torque = state_ == 4 || state_ == 5;
    const double reference = makes_torque ? ramp_ : 0.0;
    out.vector = gates_off_vector;
    if (makes_torque) {
      out.vector = std::uint8_t(
          dtc_.step(m.i_abc.a, m.i_abc.b, m.i_abc.c, m.u_dc, int(upper), applied.duration_ns, reference));
    }
    const double i_a = 0.5 * (i_a_ + m.i_abc.a), i_b = 0.5 * (i_b_ + m.i_abc.b),
                 i_c = 0.5 * (i_c_ + m.i_abc.c);
    out.i_dc = double(upper & 1U) * i_a + double(upper >> 1U & 1U) * i_b + double(upper >> 2U & 1U) * i_c;
    if (usable) {
      i_a_ = m.i_abc.a;
      i_b_ = m.i_abc.b;
      i_c_ = m.i_abc.c;
    }

    out.t_ns = t_ns;
    out.torque_requested = command.torque;
    out.torque_reference = reference;
    out.torque = dtc_.torque();
    out.psi_a = dtc_.psi_a();
    out.psi_b = dtc_.psi_b();
    out.psi = dtc_.psi();
    out.i_a = m.i_abc.a;
    out.i_b = m.i_abc.b;
    out.i_c = m.i_abc.c;
    out.u_dc = m.u_dc;
    out.omega_m = m.omega_m;
    out.motoring = motoring;
    out.regenerating = torque_limit;
    out.duration_ns = std::int32_t(period_ns);
    out.sector = std::uint8_t(dtc_.sector() + 1);
    out.state = state_;
    out.lockout = lockout_ || state_ == 6;
    out.active = faults;
    out.latched = latched_;
    out.first_fault = first_fault_;
    out.fault_total = fault_total_;
    out.command_received_ns = command.received_ns;
    out.command_sequence = command.sequence;
    out.command_rejected = command.rejected;
    out.command_counter = command.counter;
  }

  /// Forgets the flux, as `ReferenceDtc::reset`.
  void reset_estimate() { dtc_.reset(); }

  static constexpr std::uint8_t gates_off_vector = 8;

 private:
  double over_current = 200.0, over_voltage = 700.0, torque_limit = 150.0, torque_rate = 1e6;
  double base_speed = 115.0, inverse_range = 1.0 / (180.0 - 115.0);
  std::int64_t period_ns = 25'000, timeout_ns = 40'000'000, lost_ns = 200'000'000;
  ReferenceDtc dtc_{};
  double setpoint_{}, ramp_{}, zero_rate_{}, i_a_{}, i_b_{}, i_c_{};
  std::int64_t last_ns_{}, age_from_ns_{};
  std::uint64_t sequence_{};
  std::uint32_t disables_{}, resets_{}, blocked_{}, out_of_range_{}, fault_total_{};
  std::uint64_t latched_{};
  std::uint8_t state_{}, first_fault_{};
  bool started_{}, enable_{}, lockout_{true}, ramping_to_zero_{};
};

}  // namespace sextant::bench
