#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "sextant/control/controller.hpp"
#include "sextant/core/drive_request.hpp"
#include "sextant/core/elapsed.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/telemetry.hpp"
#include "sextant/core/two_level_inverter.hpp"
#include "sextant/drive/drive_state_machine.hpp"
#include "sextant/drive/fault_memory.hpp"
#include "sextant/drive/torque_capability.hpp"
#include "sextant/safety/command_supervision.hpp"
#include "sextant/safety/protection.hpp"

namespace sextant {

/// Output of one control period.
template <class T = double>
struct DriveOutput {
  GatePattern pattern{};
  Telemetry<T> telemetry{};
};

/// The torque drive: protections, command supervision, state machine and controller, once a control period.
template <class T = double>
class Drive {
 public:
  struct Parameters {
    std::int32_t period_ns{25'000};  ///< control period [ns]
    bool magnetise_first{false};     ///< build up the flux in MAGNETISING before torque [-]
    T magnetise_below_speed{T(5)};   ///< largest speed at which MAGNETISING precedes torque [rad/s]
    std::int64_t magnetise_timeout_ns{1'000'000'000};  ///< MAGNETISING for longer is a fault [ns]
    typename CommandSupervision<T>::Parameters command{};
    typename Protection<T>::Parameters protection{};
    typename TorqueCapability<T>::Parameters capability{};

    [[nodiscard]] const char* validate() const noexcept {
      if (period_ns <= 0) return "the control period must be above zero";
      if (!(std::isfinite(magnetise_below_speed) && magnetise_below_speed >= T(0))) {
        return "the speed below which to magnetise must not be below zero";
      }
      if (magnetise_timeout_ns <= 0) return "the time for magnetising must be above zero";
      if (const char* problem = command.validate()) return problem;
      if (const char* problem = protection.validate()) return problem;
      return capability.validate();
    }
  };

  /// The controller is not owned and must outlive the drive.
  Drive(const Parameters& parameters, Controller<T>& controller) noexcept
      : parameters_{parameters},
        controller_{controller},
        supervision_{parameters.command},
        protection_{parameters.protection},
        capability_{parameters.capability} {}

  /// The control period that begins at t_ns, on the clock of the commands' time stamps [ns]. Where that clock
  /// steps back, ages start from zero; where it steps forward, ages grow by the step. Never allocates, locks,
  /// throws, logs or blocks.
  [[nodiscard]] DriveOutput<T> step(std::int64_t t_ns, const Measurement<T>& measurement,
                                    const DriveRequest<T>& request) noexcept SEXTANT_NONBLOCKING {
    // More than a period where periods were missed: ramps and timeouts follow the clock.
    const std::int64_t elapsed_ns =
        std::max<std::int64_t>(elapsed(last_t_ns_.value_or(t_ns), t_ns), parameters_.period_ns);
    last_t_ns_ = t_ns;
    const FaultSet measured = protection_.step(measurement);
    const bool usable = !measured.test(Fault::measurement_invalid);
    const AvailableTorque<T> available = capability_.step(measurement.omega_m, measurement.u_dc);
    const SupervisedCommand<T> command =
        supervise(request, t_ns, elapsed_ns, available.range(measurement.omega_m));
    const bool flux_ready = !magnetising_helps(measurement.omega_m) || controller_.estimate().magnetised;
    const FaultSet missing_flux = evaluate_magnetising(flux_ready, elapsed_ns);
    update_state(present_faults(measured, missing_flux, request, command), flux_ready,
                 available.holds_zero_torque, request, command);

    const T torque_reference = makes_torque(state_) ? command.torque : T(0);
    const T i_dc = dc_link_mean(measurement);
    if (usable) i_before_ = measurement.i_abc;
    DriveOutput<T> output{control(measurement, usable, torque_reference),
                          telemetry(t_ns, measurement, i_dc, request, command, available, torque_reference)};
    output.telemetry.switch_state = output.pattern.last_state();
    return output;
  }

  [[nodiscard]] DriveState state() const noexcept { return state_; }

 private:
  [[nodiscard]] SupervisedCommand<T> supervise(const DriveRequest<T>& request, std::int64_t t_ns,
                                               std::int64_t elapsed_ns, TorqueRange<T> available) noexcept {
    // The reference stays zero until the flux is ready, so that torque starts from zero and at its rate.
    const bool hold_at_zero = request.shutdown || state_ == DriveState::magnetising;
    return supervision_.step(request.command, t_ns, T(elapsed_ns) * T(1e-9), available, hold_at_zero);
  }

  /// FLUX_LOST after the timeout without flux: the estimate is wrong, or no current flows.
  [[nodiscard]] FaultSet evaluate_magnetising(bool flux_ready, std::int64_t elapsed_ns) noexcept {
    FaultSet faults;
    if (state_ != DriveState::magnetising || flux_ready) {
      magnetising_left_ns_ = parameters_.magnetise_timeout_ns;
    } else if (elapsed_ns >= magnetising_left_ns_) {
      faults.set(Fault::flux_lost);
    } else {
      magnetising_left_ns_ -= elapsed_ns;
    }
    return faults;
  }

  /// Mean of the DC-link current since the last measurement. Over a gap of several periods the currents
  /// before it count while the gates were driven, and the currents after it for the rest: with gates off they
  /// decay within a fraction of a millisecond. [A]
  [[nodiscard]] T dc_link_mean(const Measurement<T>& measurement) const noexcept {
    const ThreePhase<T>& before = i_before_;
    const ThreePhase<T>& now = measurement.i_abc;
    const ThreePhase<T> mean{T(0.5) * (before.a + now.a), T(0.5) * (before.b + now.b),
                             T(0.5) * (before.c + now.c)};
    const GatePattern& applied = measurement.applied;
    const bool is_gap = !applied.is_driven() && applied.duration_ns() > parameters_.period_ns;
    return dc_link_current(applied, is_gap ? before : mean, is_gap ? now : mean);
  }

  /// Command faults count only while the gates are on; all others always.
  [[nodiscard]] FaultSet present_faults(FaultSet measured, FaultSet missing_flux,
                                        const DriveRequest<T>& request,
                                        const SupervisedCommand<T>& command) const noexcept {
    FaultSet faults = measured;
    faults |= missing_flux;
    faults |= request.external;
    if (gates_are_on(state_)) faults |= command.faults;
    return faults;
  }

  void update_state(FaultSet present, bool flux_ready, bool holds_zero_torque, const DriveRequest<T>& request,
                    const SupervisedCommand<T>& command) noexcept {
    faults_.step(present);
    const DriveConditions conditions{
        .trip = present.any(),
        .fault_reset = command.fault_reset,
        .shutdown = request.shutdown,
        .at_zero = command.torque == T(0),
        .lockout = command.lockout,
        .enable = command.enable,
        .holds_zero_torque = holds_zero_torque,
        .magnetised = flux_ready,
        .derated = command.derated,
    };
    const DriveState next = next_state(state_, conditions);
    if (next != state_ || next == DriveState::fault) enter(next);
  }

  void enter(DriveState next) noexcept {
    if (next == DriveState::fault) supervision_.lock();
    if (next == DriveState::ready || next == DriveState::magnetising) supervision_.restart();
    if (state_ == DriveState::fault && next == DriveState::standby) faults_.reset();
    state_ = next;
  }

  /// Direct current magnetises a machine at rest and brakes a turning one.
  [[nodiscard]] bool magnetising_helps(T omega_m) const noexcept {
    return parameters_.magnetise_first && std::abs(omega_m) <= parameters_.magnetise_below_speed;
  }

  [[nodiscard]] GatePattern control(const Measurement<T>& measurement, bool usable,
                                    T torque_reference) noexcept {
    if (!usable) {
      controller_.reset();
      return GatePattern{gates_off, parameters_.period_ns};
    }
    ControlMode mode = ControlMode::off;
    if (state_ == DriveState::magnetising) mode = ControlMode::magnetise;
    if (makes_torque(state_)) mode = ControlMode::torque;
    return controller_.step(measurement, {mode, torque_reference});
  }

  /// The record of the period but for the switching state, once the controller has made its step.
  [[nodiscard]] Telemetry<T> telemetry(std::int64_t t_ns, const Measurement<T>& measurement, T i_dc,
                                       const DriveRequest<T>& request, const SupervisedCommand<T>& command,
                                       AvailableTorque<T> available, T torque_reference) const noexcept {
    const ControlEstimate<T>& estimate = controller_.estimate();
    return {.t_ns = t_ns,
            .i_abc = measurement.i_abc,
            .u_dc = measurement.u_dc,
            .omega_m = measurement.omega_m,
            .i_dc = i_dc,
            .psi_s = estimate.psi_s,
            .psi_s_magnitude = estimate.psi_s_magnitude,
            .torque = estimate.torque,
            .torque_requested = request.command.torque,
            .torque_reference = torque_reference,
            .torque_motoring = available.motoring,
            .torque_regenerating = available.regenerating,
            .active = faults_.active(),
            .latched = faults_.latched(),
            .fault_total = faults_.total(),
            .first_fault = faults_.first(),
            .command_received_ns = request.command.received_ns,
            .command_sequence = request.command.sequence,
            .command_rejected = request.command.rejected,
            .command_counter = request.command.counter,
            .sector = estimate.sector,
            .state = state_,
            .lockout = command.lockout || state_ == DriveState::fault};
  }

  Parameters parameters_;
  Controller<T>& controller_;
  CommandSupervision<T> supervision_;
  Protection<T> protection_;
  TorqueCapability<T> capability_;
  FaultMemory faults_{};
  std::optional<std::int64_t> last_t_ns_{};  ///< of the period before [ns]
  std::int64_t magnetising_left_ns_{0};      ///< until MAGNETISING is a fault [ns]
  ThreePhase<T> i_before_{};                 ///< the last usable phase currents [A]
  DriveState state_{DriveState::init};
};

}  // namespace sextant
