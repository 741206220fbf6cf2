#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sextant/control/controller.hpp"
#include "sextant/core/drive_request.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/telemetry.hpp"
#include "sextant/core/two_level_inverter.hpp"
#include "sextant/drive/drive_state_machine.hpp"
#include "sextant/drive/fault_memory.hpp"
#include "sextant/drive/torque_capability.hpp"
#include "sextant/safety/command_gate.hpp"
#include "sextant/safety/protection.hpp"

namespace sextant {

/// What a drive answers to one control period.
template <class T = double>
struct DriveOutput {
  GatePattern pattern{};
  Telemetry<T> telemetry{};
};

/// The torque drive: protections, command gate, state machine and controller, once a control period.
template <class T = double>
class Drive {
 public:
  struct Parameters {
    std::int32_t period_ns{25'000};  ///< control period [ns]
    bool magnetise_first{false};     ///< wait in MAGNETISING until the flux stands, before torque [-]
    T magnetise_below_speed{T(5)};   ///< above it, torque starts without magnetising first [rad/s]
    typename CommandGate<T>::Parameters gate{};
    typename Protection<T>::Parameters protection{};
    typename TorqueCapability<T>::Parameters capability{};

    [[nodiscard]] const char* validate() const noexcept {
      if (period_ns <= 0) return "the control period must be above zero";
      if (!(std::isfinite(magnetise_below_speed) && magnetise_below_speed >= T(0))) {
        return "the speed below which to magnetise must not be below zero";
      }
      if (const char* problem = gate.validate()) return problem;
      if (const char* problem = protection.validate()) return problem;
      return capability.validate();
    }
  };

  /// The controller is not owned and must outlive the drive.
  Drive(const Parameters& parameters, Controller<T>& controller) noexcept
      : parameters_{parameters},
        controller_{controller},
        gate_{parameters.gate},
        protection_{parameters.protection},
        capability_{parameters.capability} {}

  /// One control period. Never allocates, locks, throws, logs or blocks.
  [[nodiscard, gnu::always_inline]] DriveOutput<T> step(
      const Measurement<T>& measurement, const DriveRequest<T>& request) noexcept SEXTANT_NONBLOCKING {
    // The same code twice, of which the first leaves out what `is_usual` has settled: half of all checks.
    if (is_usual(measurement, request)) [[likely]]
      return answer(measurement, request, true);
    return answer_to_any(measurement, request);
  }

  [[nodiscard]] DriveState state() const noexcept { return state_; }

 private:
  /// True when torque is being produced and may go on: nothing new is asked and nothing is wrong.
  [[nodiscard]] bool is_usual(const Measurement<T>& measurement,
                              const DriveRequest<T>& request) const noexcept {
    return makes_torque(state_) && (unsigned(request.shutdown) | request.external.bits()) == 0 &&
           protection_.is_harmless(measurement) && gate_.is_steady(request.command, measurement.t_ns) &&
           // Asked last and in this order, so that the speed is compared once for this and for the
           // capability.
           (capability_.is_full(measurement.omega_m) || std::isfinite(measurement.omega_m));
  }

  [[nodiscard, gnu::noinline]] DriveOutput<T> answer_to_any(const Measurement<T>& measurement,
                                                            const DriveRequest<T>& request) noexcept {
    return answer(measurement, request, false);
  }

  /// `usual` is known to the compiler in each of its two places.
  [[nodiscard, gnu::always_inline]] DriveOutput<T> answer(const Measurement<T>& measurement,
                                                          const DriveRequest<T>& request,
                                                          bool usual) noexcept {
    const FaultSet measured = usual ? FaultSet{} : protection_.step(measurement);
    const bool usable = !measured.test(Fault::measurement_invalid);
    const AvailableTorque<T> available = capability_.at(measurement.omega_m);
    // No torque is admitted ahead of the flux, so that it starts from zero and at its admitted rate.
    const bool hold_at_zero = request.shutdown || state_ == DriveState::magnetising;
    const std::int64_t elapsed_ns = measurement.t_ns - last_t_ns_;
    last_t_ns_ = measurement.t_ns;
    const AdmittedCommand<T> admitted =
        usual && gate_.is_settled(request.command, available.either_way())
            ? gate_.settled()
            : admit(measurement, request, elapsed_ns, available, usual, hold_at_zero);
    if (usual) {  // no fault is active where torque was made, so that there is none to forget
      state_ = admitted.derated ? DriveState::derated : DriveState::torque;
    } else {
      update_state(measured, measurement.omega_m, request, admitted);
    }

    const DriveState state = state_;  // known here, but no longer after a virtual call
    const T torque_reference = makes_torque(state) ? admitted.torque : T(0);
    // Made in place: a copy of what has just been stored by member stalls.
    DriveOutput<T> out{.pattern = control(measurement, usable, torque_reference),
                       .telemetry = telemetry(measurement, request, admitted, available, state,
                                              torque_reference, out.pattern)};
    if (usable) i_before_ = measurement.i_abc;
    return out;
  }

  /// Whatever the command is. It takes effect over one period, or over more where late periods were skipped,
  /// so that ramps keep to the clock.
  [[nodiscard, gnu::always_inline]] AdmittedCommand<T> admit(const Measurement<T>& measurement,
                                                             const DriveRequest<T>& request,
                                                             std::int64_t elapsed_ns,
                                                             AvailableTorque<T> available, bool usual,
                                                             bool hold_at_zero) noexcept {
    const T dt = T(std::max<std::int64_t>(elapsed_ns, parameters_.period_ns)) * T(1e-9);
    const TorqueRange<T> range = available.range(measurement.omega_m);
    return usual ? gate_.pass(request.command, measurement.t_ns, dt, range)
                 : gate_.step(request.command, measurement.t_ns, dt, range, hold_at_zero);
  }

  /// Mean of the DC-link current since the last measurement. After a gap of several periods the currents of
  /// before count while the gates were still driven, and those of now for the rest: they die within the first
  /// part of a millisecond. [A]
  [[nodiscard]] T dc_link_mean(const Measurement<T>& measurement) const noexcept {
    const ThreePhase<T>& x = i_before_;
    const ThreePhase<T>& y = measurement.i_abc;
    const GatePattern& acted = measurement.acted;
    const ThreePhase<T> sum{x.a + y.a, x.b + y.b, x.c + y.c};
    if (acted.is_driven() && acted.segments().size() == 1) [[likely]] {
      return T(0.5) * driven_dc_link_current(acted.segments().front().state, sum);
    }
    if (!acted.is_driven() && acted.duration_ns() > parameters_.period_ns)
      return dc_link_current(acted, x, y);
    const ThreePhase<T> mean{T(0.5) * sum.a, T(0.5) * sum.b, T(0.5) * sum.c};
    return dc_link_current(acted, mean, mean);
  }

  /// A fault of the command matters only while the gates are on; all others matter always.
  [[nodiscard]] FaultSet present_faults(FaultSet measured, const DriveRequest<T>& request,
                                        const AdmittedCommand<T>& admitted) const noexcept {
    FaultSet faults = measured;
    faults |= request.external;
    if (gates_are_on(state_)) faults |= admitted.faults;
    return faults;
  }

  void update_state(FaultSet measured, T omega_m, const DriveRequest<T>& request,
                    const AdmittedCommand<T>& admitted) noexcept {
    faults_.step(present_faults(measured, request, admitted));
    const DriveConditions conditions{
        .trip = faults_.active().any(),
        .fault_reset = admitted.fault_reset,
        .shutdown = request.shutdown,
        .wound_down = admitted.torque == T(0),
        .lockout = admitted.lockout,
        .enable = admitted.enable,
        .magnetised = !magnetising_helps(omega_m) || controller_.estimate().magnetised,
        .derated = admitted.derated,
    };
    const DriveState next = next_state(state_, conditions);
    if (next != state_ || next == DriveState::fault) enter(next);
  }

  void enter(DriveState next) noexcept {
    if (next == DriveState::fault) gate_.lock();
    if (next == DriveState::magnetising && state_ != next) gate_.restart();
    if (state_ == DriveState::fault && next == DriveState::standby) faults_.reset();
    state_ = next;
  }

  /// Direct current magnetises a machine at rest; on a turning one it would brake.
  [[nodiscard]] bool magnetising_helps(T omega_m) const noexcept {
    return parameters_.magnetise_first && std::abs(omega_m) <= parameters_.magnetise_below_speed;
  }

  [[nodiscard]] GatePattern control(const Measurement<T>& measurement, bool usable,
                                    T torque_reference) noexcept {
    if (!usable) [[unlikely]] {
      controller_.reset();
      return GatePattern{gates_off, parameters_.period_ns};
    }
    ControlMode mode = ControlMode::off;
    if (state_ == DriveState::magnetising) mode = ControlMode::magnetise;
    if (makes_torque(state_)) mode = ControlMode::torque;
    return controller_.step(measurement, {mode, torque_reference});
  }

  [[nodiscard]] Telemetry<T> telemetry(const Measurement<T>& measurement, const DriveRequest<T>& request,
                                       const AdmittedCommand<T>& admitted, AvailableTorque<T> available,
                                       DriveState state, T torque_reference,
                                       const GatePattern& pattern) const noexcept {
    const ControlEstimate<T>& estimate = controller_.estimate();
    return {.t_ns = measurement.t_ns,
            .i_abc = measurement.i_abc,
            .u_dc = measurement.u_dc,
            .omega_m = measurement.omega_m,
            .i_dc = dc_link_mean(measurement),
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
            .switch_state = pattern.last_state(),
            .command_received_ns = request.command.received_ns,
            .command_sequence = request.command.sequence,
            .command_rejected = request.command.rejected,
            .command_counter = request.command.counter,
            .sector = estimate.sector,
            .state = state,
            .lockout = admitted.lockout || state == DriveState::fault};
  }

  Parameters parameters_;
  Controller<T>& controller_;
  CommandGate<T> gate_;
  Protection<T> protection_;
  TorqueCapability<T> capability_;
  FaultMemory faults_{};
  /// Before the first step half of eternity ahead, so that it counts as one period. [ns]
  std::int64_t last_t_ns_{std::numeric_limits<std::int64_t>::max() / 2};
  ThreePhase<T> i_before_{};  ///< the last usable phase currents [A]
  DriveState state_{DriveState::init};
};

}  // namespace sextant
