#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "sextant/control/controller.hpp"
#include "sextant/core/drive_request.hpp"
#include "sextant/core/elapsed.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/sampling_instant.hpp"
#include "sextant/core/telemetry.hpp"
#include "sextant/drive/anti_jerk.hpp"
#include "sextant/drive/available_torque.hpp"
#include "sextant/drive/dc_link_mean.hpp"
#include "sextant/drive/drive_output.hpp"
#include "sextant/drive/drive_parameters.hpp"
#include "sextant/drive/drive_state_machine.hpp"
#include "sextant/drive/fault_memory.hpp"
#include "sextant/drive/induction_motor.hpp"
#include "sextant/drive/link_voltage_band.hpp"
#include "sextant/drive/motor_control.hpp"
#include "sextant/safety/command_supervision.hpp"
#include "sextant/safety/protection.hpp"
#include "sextant/safety/torque_monitor.hpp"

namespace sextant {

/// The torque drive: protections, command supervision, state machine, torque monitor and the motor with its
/// control, once a control period.
template <class T = double, class Motor = InductionMotor<T>>
  requires MotorControl<Motor, T>
class Drive {
 public:
  using Parameters = DriveParameters<T, Motor>;

  /// `parts`: what the motor is constructed with beside its parameters, of an `InductionMotor` its
  /// controller, which is not owned and must outlive the drive. A pattern that does not fill the control
  /// period is not applied: the gates are off in that period, and where they were to be on it is the fault
  /// TORQUE_PLAUSIBILITY, as the torque cannot follow its reference.
  template <class... Parts>
  explicit Drive(const Parameters& parameters, Parts&... parts) noexcept
      : parameters_{parameters},
        motor_{parameters.motor, parameters.timing(), parts...},
        sampling_{parameters.sampling_lead_ns},
        supervision_{parameters.command},
        protection_{parameters.protection},
        low_voltage_{parameters.low_voltage},
        high_voltage_{parameters.high_voltage},
        torque_monitor_{parameters.torque_monitor},
        anti_jerk_{parameters.anti_jerk} {}

  /// The control period that begins at t_ns, on the clock of the commands' time stamps [ns]. Where that clock
  /// steps back, ages start from zero; where it steps forward, ages grow by the step. Never allocates, locks,
  /// throws, logs or blocks.
  [[nodiscard]] DriveOutput<T> step(std::int64_t t_ns, const Measurement<T>& raw,
                                    const DriveRequest<T>& request) noexcept SEXTANT_NONBLOCKING {
    // More than a period where periods were missed: ramps and timeouts follow the clock.
    const std::int64_t elapsed_ns =
        std::max<std::int64_t>(elapsed(last_t_ns_.value_or(t_ns), t_ns), parameters_.period_ns);
    last_t_ns_ = t_ns;
    const Measurement<T>& sampled = sampling_.step(raw);
    const T dt = T(elapsed_ns) * T(1e-9);
    const bool usable = protection_.is_usable(raw);
    FaultSet measured = monitor_torque(sampled, usable && state_ != DriveState::fault, dt);
    measured |= protection_.step(sampled, protection_inputs());
    const Measurement<T> measurement = usable ? protection_.without_offset(raw) : raw;
    AvailableTorque<T> available = available_torque(measurement, dt);
    const LimitedTorque<T> present = present_limit(available);
    const TorqueRange<T> range = available.range(measurement.omega_m).within(present.torque);
    const SupervisedCommand<T> command = supervise(request, t_ns, dt, range);
    const bool limited = std::abs(command.torque) >= present.torque;
    LimitedTorque<T>& side = available.side(command.setpoint, measurement.omega_m);
    if (limited) side.lower_to(present);
    limit_to_reached(command.setpoint, side);
    const bool flux_ready = !parameters_.magnetise_first || motor_.estimate().magnetised;
    const FaultSet missing_flux = evaluate_magnetising(flux_ready, elapsed_ns);
    // A power stage whose first measurement is yet to come has no fault.
    if (state_ == DriveState::init && !usable) measured = {};
    update_state(present_faults(measured, missing_flux, request, command), request, command,
                 {.measured = usable,
                  .supplied = measurement.u_dc >= parameters_.ready_voltage,
                  .magnetised = flux_ready,
                  .derated = command.derated || lags()});

    const T i_dc = dc_link_.at(measurement, parameters_.period_ns);
    if (usable) dc_link_.begin_at(measurement.i_abc);
    const T steady = makes_torque(state_) ? command.torque : T(0);
    const MotorDemand<T> demand{
        .mode = control_mode(),
        .torque = anti_jerk_.acts() ? damped(measurement, usable, command, range, dt) : steady,
        .steady_torque = steady,
        .at_present_limit = limited,
        .limited = limited || command.derated};
    DriveOutput<T> output{control(believed(measurement, usable, elapsed_ns), demand, dt),
                          telemetry(t_ns, measurement, i_dc, request, command, available)};
    output.telemetry.pattern = output.pattern;
    return output;
  }

  [[nodiscard]] DriveState state() const noexcept { return state_; }

  /// Whether its motor does.
  [[nodiscard]] bool takes_parameters() const noexcept { return motor_.takes_parameters(); }

  /// Takes what may always change (`Changes`) from another drive, of which the rest is the same, between two
  /// periods. State, fluxes, temperatures and filters stay. To be called where the drive `takes_parameters`.
  void take_parameters(const Drive& from) noexcept SEXTANT_NONBLOCKING {
    parameters_ = from.parameters_;
    motor_.take_parameters(from.motor_);
    supervision_.take_parameters(from.supervision_);
    protection_.take_parameters(from.protection_);
    low_voltage_.take_parameters(from.low_voltage_);
    high_voltage_.take_parameters(from.high_voltage_);
    torque_monitor_.take_parameters(from.torque_monitor_);
    anti_jerk_.take_parameters(from.anti_jerk_);
  }

  /// The gates are off and the torque monitor's rotor flux is below a twentieth of the flux reference: a
  /// drive with other parameters may `continue_after` this one.
  [[nodiscard]] bool is_at_rest() const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> psi_r = torque_monitor_.psi_r();
    const T most = T(0.05) * motor_.flux_reference();
    return !gates_are_on(state_) && dot(psi_r, psi_r) <= most * most;
  }

  /// Takes the place of a drive of the same period that `is_at_rest`, before its own first period: takes over
  /// state, faults, command and what is known of sensors and winding. Estimates begin as after power-up.
  void continue_after(const Drive& before) noexcept SEXTANT_NONBLOCKING {
    const CommandSupervision<T> own = supervision_;
    supervision_ = before.supervision_;
    supervision_.take_parameters(own);
    protection_.continue_after(before.protection_);
    faults_ = before.faults_;
    last_t_ns_ = before.last_t_ns_;
    dc_link_ = before.dc_link_;
    believed_ = before.believed_;
    state_ = before.state_;
  }

 private:
  /// What the drive did with the measurement before, and the rotor flux at this one.
  [[nodiscard]] ProtectionInputs<T> protection_inputs() const noexcept {
    const ControlEstimate<T>& estimate = motor_.estimate();
    return {.makes_torque = makes_torque(state_),
            .torque_reference = motor_.reference().torque,
            .flux_reference = motor_.flux_reference(),
            .torque = estimate.torque,
            .psi_s = estimate.psi_s_magnitude,
            .psi_r = torque_monitor_.psi_r(),
            .psi_r_error = torque_monitor_.psi_r_error()};
  }

  [[nodiscard]] SupervisedCommand<T> supervise(const DriveRequest<T>& request, std::int64_t t_ns, T dt,
                                               TorqueRange<T> available) noexcept {
    // The reference stays zero until the flux is ready, so that torque starts from zero and at its rate.
    const ZeroRequest zero = request.shutdown                    ? ZeroRequest::shutdown
                             : state_ == DriveState::magnetising ? ZeroRequest::awaits_flux
                                                                 : ZeroRequest::none;
    return supervision_.step(request.command, t_ns, dt, available, zero, request.status_age_ns);
  }

  /// What machine, link and winding allow in a steady state.
  [[nodiscard]] AvailableTorque<T> available_torque(const Measurement<T>& measurement, T dt) noexcept {
    AvailableTorque<T> available = motor_.available(measurement, dt);
    low_voltage_.step(measurement.u_dc, dt);
    high_voltage_.step(measurement.u_dc, dt);
    const LimitedShare<T> winding{protection_.available_share(), DeratingCause::temperature};
    available.motoring.lower_by(
        least(winding, LimitedShare<T>{low_voltage_.share(), DeratingCause::dc_link_low}));
    available.regenerating.lower_by(
        least(winding, LimitedShare<T>{high_voltage_.share(), DeratingCause::dc_link_high}));
    return available;
  }

  /// What the motor's present state allows, while torque is made.
  [[nodiscard]] LimitedTorque<T> present_limit(const AvailableTorque<T>& available) const noexcept {
    if (!makes_torque(state_)) return {};
    const T enough = std::max(available.motoring.torque, available.regenerating.torque);
    return motor_.present_limit(enough);
  }

  /// The voltage holds the torque off its reference.
  [[nodiscard]] bool lags() const noexcept { return makes_torque(state_) && torque_monitor_.lags(); }

  /// Lowers what is available in the direction of a setpoint [N·m] to what the voltage has let the torque
  /// reach of it. A torque beyond the setpoint, or beside one of zero, leaves what is available.
  void limit_to_reached(T setpoint, LimitedTorque<T>& available) const noexcept {
    if (!lags() || setpoint == T(0)) return;
    const T torque = torque_monitor_.reach().torque();
    const T reached = setpoint < T(0) ? -torque : torque;
    if (reached < std::abs(setpoint)) {
      available.lower_to({std::max(T(0), reached), DeratingCause::voltage_limit});
    }
  }

  /// Time for which the reported pattern acted, which a stall of the power stage's side separates from the
  /// drive's own dt; dt without a pattern. [s]
  [[nodiscard]] static T acted(const Measurement<T>& m, T dt) noexcept {
    const std::int64_t acted_ns = m.applied.duration_ns();
    return acted_ns > 0 ? T(acted_ns) * T(1e-9) : dt;
  }

  /// TORQUE_PLAUSIBILITY where the torque since the last period does not follow the reference in force then.
  /// In FAULT readings are kept from the monitor as from the motor's control.
  [[nodiscard]] FaultSet monitor_torque(const Measurement<T>& measurement, bool trusted, T dt) noexcept {
    FaultSet faults;
    const std::optional<T> commanded =
        makes_torque(state_) ? std::optional<T>{motor_.reference().torque} : std::nullopt;
    if (!trusted) {
      torque_monitor_.coast(dt);
    } else if (torque_monitor_.step(measurement, acted(measurement, dt), commanded)) {
      faults.set(Fault::torque_plausibility);
    }
    return faults;
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

  /// `conditions`: measured, supplied, magnetised and derated; the others follow from the rest.
  void update_state(FaultSet present, const DriveRequest<T>& request, const SupervisedCommand<T>& command,
                    DriveConditions conditions) noexcept {
    faults_.step(present);
    conditions.trip = present.any();
    conditions.fault_reset = command.fault_reset;
    conditions.shutdown = request.shutdown;
    conditions.at_zero = command.torque == T(0);
    conditions.lockout = command.lockout;
    conditions.enable = command.enable;
    const DriveState next = next_state(state_, conditions);
    if (next != state_ || next == DriveState::fault) enter(next);
  }

  void enter(DriveState next) noexcept {
    if (next == DriveState::fault) supervision_.lock();
    if (next == DriveState::ready || next == DriveState::magnetising) supervision_.restart();
    if (state_ == DriveState::fault && next == DriveState::standby) {
      faults_.reset();
      protection_.leave_fault();
      motor_.restart();
    }
    state_ = next;
  }

  /// What the motor's control sees: the winding's temperature where it is not measured is the model's. In
  /// FAULT, with the gates off, it sees no reading of current and voltage, one of which may be what tripped:
  /// no current flows, and the rotor flux decays as it turns, by the measured speed unless that is in doubt.
  [[nodiscard]] const Measurement<T>& believed(const Measurement<T>& measurement, bool usable,
                                               std::int64_t elapsed_ns) noexcept {
    const bool in_fault = state_ == DriveState::fault;
    if (usable && !in_fault) believed_ = measurement;
    believed_.winding_temperature = protection_.winding_temperature();
    if (usable && !in_fault) return believed_;
    const FaultSet active = faults_.active();
    const bool has_speed = usable && !active.test(Fault::speed_sensor) && !active.test(Fault::over_speed);
    if (has_speed) believed_.omega_m = measurement.omega_m;
    believed_.i_abc = {};
    const auto longest = std::int64_t{std::numeric_limits<std::int32_t>::max()};
    believed_.applied = GatePattern{gates_off, std::int32_t(std::min(elapsed_ns, longest))};
    return believed_;
  }

  /// The torque reference with what damps the shaft, which the drive publishes, and compares the torque with.
  /// While the reference ramps to zero the correction is at most the share of it, and ends with it. [N·m]
  [[nodiscard]] T damped(const Measurement<T>& measurement, bool usable, const SupervisedCommand<T>& command,
                         TorqueRange<T> range, T dt) noexcept {
    if (usable) anti_jerk_.step(measurement.omega_m, dt);
    if (!makes_torque(state_)) return T(0);
    const T full =
        is_ramp_to_zero(command.ramp) ? std::abs(command.torque) : parameters_.command.torque_limit;
    return anti_jerk_.corrected(command.torque, full, range);
  }

  /// The motor's pattern of the coming period, or gates off where that does not fill it.
  [[nodiscard]] GatePattern control(const Measurement<T>& measurement, const MotorDemand<T>& demand,
                                    T dt) noexcept {
    GatePattern pattern = motor_.step(measurement, demand, dt);
    if (pattern.duration_ns() != parameters_.period_ns) {
      motor_.discard_pattern();
      if (gates_are_on(state_)) trip(Fault::torque_plausibility);
      pattern = {gates_off, parameters_.period_ns};
    }
    return pattern;
  }

  /// A fault that shows once the state of the period is decided: the gates are off in the same period.
  void trip(Fault fault) noexcept {
    FaultSet present = faults_.active();
    present.set(fault);
    faults_.step(present);
    enter(DriveState::fault);
  }

  [[nodiscard]] ControlMode control_mode() const noexcept {
    if (makes_torque(state_)) return ControlMode::torque;
    return state_ == DriveState::magnetising ? ControlMode::magnetise : ControlMode::off;
  }

  /// The record of the period but for the switching state, once the motor has made its step.
  [[nodiscard]] Telemetry<T> telemetry(std::int64_t t_ns, const Measurement<T>& measurement, T i_dc,
                                       const DriveRequest<T>& request, const SupervisedCommand<T>& command,
                                       const AvailableTorque<T>& available) const noexcept {
    const ControlEstimate<T>& estimate = motor_.estimate();
    const T torque_reference = motor_.reference().torque;
    return {.t_ns = t_ns,
            .i_abc = measurement.i_abc,
            .u_dc = measurement.u_dc,
            .omega_m = measurement.omega_m,
            .i_dc = i_dc,
            .psi_s = estimate.psi_s,
            .psi_s_magnitude = estimate.psi_s_magnitude,
            .torque = estimate.torque,
            .r_s = estimate.r_s,
            .r_r = estimate.r_r,
            .l_m = estimate.l_m,
            .r_s_deviation = estimate.r_s_deviation,
            .r_r_deviation = estimate.r_r_deviation,
            .l_m_deviation = estimate.l_m_deviation,
            .torque_monitored = torque_monitor_.torque(),
            .torque_requested = request.command.torque,
            .torque_reference = torque_reference,
            .torque_reached = lags() ? torque_monitor_.reach().torque() : torque_reference,
            .torque_motoring = available.motoring.torque,
            .torque_regenerating = available.regenerating.torque,
            .winding_temperature = protection_.winding_temperature(),
            .active = faults_.active(),
            .latched = faults_.latched(),
            .fault_total = faults_.total(),
            .first_fault = faults_.first(),
            .unchecked_periods = protection_.unchecked_periods(),
            .command_received_ns = request.command.received_ns,
            .command_sequence = request.command.sequence,
            .command_rejected = request.command.rejected,
            .command_counter = request.command.counter,
            .sector = estimate.sector,
            .state = state_,
            .derating_cause = derating_cause(available.side(command.setpoint, measurement.omega_m), command,
                                             measurement.u_dc),
            .lockout = command.lockout || state_ == DriveState::fault};
  }

  /// What makes the torque another than requested. `limit`: that of the side of the setpoint, in whose
  /// direction the drive publishes its limits, and less torque than that makes it DERATED. A torque that lags
  /// its reference, short of it or beyond it, is the voltage's. In STANDBY a link of u_dc [V] that is not
  /// charged is named.
  [[nodiscard]] DeratingCause derating_cause(const LimitedTorque<T>& limit,
                                             const SupervisedCommand<T>& command, T u_dc) const noexcept {
    if (state_ == DriveState::standby && u_dc < parameters_.ready_voltage) return DeratingCause::dc_link_low;
    if (!gates_are_on(state_)) return DeratingCause::gates_are_off;
    // While the flux builds up zero torque is no ramp of the reference.
    if (makes_torque(state_) && is_ramp_to_zero(command.ramp)) return command.ramp;
    return lags() ? DeratingCause::voltage_limit : limit.cause;
  }

  Parameters parameters_;
  Motor motor_;
  SamplingInstant<T> sampling_;
  CommandSupervision<T> supervision_;
  Protection<T> protection_;
  LinkVoltageBand<T> low_voltage_;
  LinkVoltageBand<T> high_voltage_;
  TorqueMonitor<T> torque_monitor_;
  AntiJerk<T> anti_jerk_;
  FaultMemory faults_{};
  std::optional<std::int64_t> last_t_ns_{};  ///< of the period before [ns]
  std::int64_t magnetising_left_ns_{0};      ///< until MAGNETISING is a fault [ns]
  DcLinkMean<T> dc_link_{};
  Measurement<T> believed_{};  ///< of the motor's last step
  DriveState state_{DriveState::init};
};

}  // namespace sextant
