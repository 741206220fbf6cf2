#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include <Eigen/Core>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/two_level_inverter.hpp"
#include "sextant/plant/appended_pair.hpp"
#include "sextant/plant/appended_system.hpp"
#include "sextant/plant/back_emf.hpp"
#include "sextant/plant/drive_plant_parameters.hpp"
#include "sextant/plant/induction_machine.hpp"
#include "sextant/plant/inverse_inductance.hpp"
#include "sextant/plant/inverter.hpp"
#include "sextant/plant/plant_machine.hpp"

namespace sextant {

/// Inverter, machine, shaft and an appended system as one ordinary differential equation:
///   dpsi_s/dt   = u_s − R_s i_s
///   dpsi_r/dt   = −R_r i_r + j p omega_m psi_r, and what iron loss takes
///   domega_m/dt = (tau_e − tau_l − B omega_m − tau_road(omega_m)) / (J + J_road), or the imposed slope
///   dtheta_m/dt = omega_m
/// Torques are positive in the direction of positive speed, except tau_l, which opposes it. While legs are
/// off, u_s depends on the state through the back-EMF and the ties of the legs change at events; where the
/// inverter has a threshold voltage, always. Its slope resistance counts to R_s, and u_s is the voltage in
/// front of both.
///
/// An appended system that feeds back (`FeedbackSystem`) changes the inputs that are set to those that act,
/// by its states; its events follow those of the legs.
///
/// The plant holds the state and the inputs; a `PlantIntegrator` moves the state. `revision()` changes
/// whenever the right-hand side or the state jumps, and only then; `jumps()` leaves out what an integrator
/// gets over without a restart: another voltage while every leg is driven, and a load that moves in small
/// steps, as one with a slope does; where a load jumps, the integrator is to be reset.
///
/// `Machine` holds the equations between fluxes, currents and torque; the default is the induction machine,
/// linear or with a main flux that saturates. Another machine is a class with the functions of
/// `PlantMachine`; examples/pm_machine has one.
template <class T = double, class Appended = NoAppendedSystem<T>, class Machine = InductionMachine<T>>
  requires AppendedSystem<Appended, T> && PlantMachine<Machine, T> &&
           (!feeds_back<Appended> || FeedbackSystem<Appended, T>)
class DrivePlant {
 public:
  using Scalar = T;
  using AppendedType = Appended;
  static constexpr bool appends_integrals = is_integral<Appended>;
  static constexpr bool feeds_back = sextant::feeds_back<Appended>;
  static constexpr int machine_size = 6;
  static constexpr int size = machine_size + Appended::size;
  /// The last state has no say in the steps of an integrator with error control.
  static constexpr bool last_is_uncontrolled = sextant::last_is_uncontrolled<Appended>;
  static constexpr int event_count = Inverter<T>::event_count + appended_event_count<Appended>;
  /// Elements of the state; the appended system's follow.
  enum Index : int { psi_s_alpha, psi_s_beta, psi_r_alpha, psi_r_beta, omega, theta, appended };
  using State = Eigen::Matrix<T, size, 1>;
  /// The same without the appended system's.
  using MachineState = Eigen::Matrix<T, machine_size, 1>;
  using Jacobian = Eigen::Matrix<T, size, size>;
  using Events = std::array<T, std::size_t(event_count)>;
  /// States of the appended system.
  using Integrals = std::array<T, std::size_t(Appended::size)>;

  /// In the initial state of the parameters, gates off. The parameters must be valid.
  explicit DrivePlant(const DrivePlantParameters<T>& parameters, Appended appended_system = Appended{})
      : DrivePlant{parameters, std::move(appended_system), machine_of(parameters)} {}

  /// The same with a machine that has other parameters than `parameters`; its stator resistance has the
  /// inverter's slope resistance in it.
  DrivePlant(const DrivePlantParameters<T>& parameters, Appended appended_system, const Machine& machine)
      : machine_{machine},
        appended_{std::move(appended_system)},
        inverse_inertia_{T(1) / (parameters.machine.inertia + parameters.road_load.coupled_inertia)},
        viscous_friction_{parameters.viscous_friction},
        road_load_{parameters.road_load},
        on_road_{parameters.road_load.acts()},
        feels_road_{on_road_},
        drops_{parameters.drops},
        inverter_{parameters.drops.threshold_voltage} {
    note_stator_resistance();
    begin(parameters.initial);
    settle_inverter();
  }

  /// Inputs of the segment to come; equal inputs change nothing, but for duties, whose thresholds follow the
  /// currents.
  void set_inputs(const PlantInputs<T>& inputs) noexcept SEXTANT_NONBLOCKING {
    if (inputs == inputs_ && !inputs.duties) return;
    const bool bridge_changed = inputs.state != inputs_.state || inputs.u_dc != inputs_.u_dc ||
                                inputs.duties.has_value() || inputs_.duties.has_value();
    // By member, as the caller stored it.
    if (inputs.imposed_speed != inputs_.imposed_speed) ++jumps_;
    inputs_.state = inputs.state;
    inputs_.u_dc = inputs.u_dc;
    inputs_.tau_l = inputs.tau_l;
    inputs_.imposed_speed = inputs.imposed_speed;
    feels_road_ = on_road_ && !inputs.imposed_speed;
    inputs_.speed_slope = inputs.speed_slope;
    inputs_.inverter_loss = inputs.inverter_loss;
    inputs_.duties = inputs.duties;
    inputs_.contactor = inputs.contactor;
    ++revision_;
    if constexpr (feeds_back) settle_appended();
    if (!bridge_changed) return;
    note_link_voltage();
    settle_inverter();
  }
  /// Leg states of the segment to come, the other inputs as they are.
  void set_switch_state(SwitchState state) noexcept SEXTANT_NONBLOCKING {
    if (state == inputs_.state) return;
    inputs_.state = state;
    ++revision_;
    settle_inverter();
  }
  [[nodiscard]] const PlantInputs<T>& inputs() const noexcept SEXTANT_NONBLOCKING { return inputs_; }

  /// Opens the motor cable of phase 0, 1 or 2: no current flows in it from its next zero on.
  /// `Inverter::no_phase` makes the cables whole again.
  void open_phase(int phase) noexcept SEXTANT_NONBLOCKING {
    if (phase == inverter_.open_phase()) return;
    inverter_.open_phase(phase, i_s());
    note_jump();
    settle_inverter();
  }

  /// Replaces the machine's resistances, that of the stator with the inverter's slope resistance in it [Ω];
  /// the same change nothing. The state stays. Integrators are to be reset.
  void set_resistances(T r_s, T r_r) noexcept SEXTANT_NONBLOCKING {
    const InductionMachineParameters<T>& m = machine_.parameters();
    if (r_s == m.r_s && r_r == m.r_r) return;
    machine_.set_resistances(r_s, r_r);
    note_stator_resistance();
    if constexpr (has_resistances<Appended>) appended_.set_resistances(r_s, r_r);
    note_jump();
    settle_inverter();
  }

  /// Replaces the state from outside, so that an integrator restarts.
  void set_state(const State& x) noexcept SEXTANT_NONBLOCKING {
    x_ = x;
    note_jump();
    if constexpr (feeds_back) {
      settle_appended();
      note_link_voltage();
    }
    settle_inverter();
  }
  /// Flux linkages, stationary frame. [Wb]
  void set_fluxes(SpaceVector<T> stator, SpaceVector<T> rotor) noexcept SEXTANT_NONBLOCKING {
    State x = x_;
    x[psi_s_alpha] = stator.alpha;
    x[psi_s_beta] = stator.beta;
    x[psi_r_alpha] = rotor.alpha;
    x[psi_r_beta] = rotor.beta;
    set_state(x);
  }
  /// Mechanical speed [rad/s].
  void set_speed(T omega_m) noexcept SEXTANT_NONBLOCKING {
    State x = x_;
    x[omega] = omega_m;
    set_state(x);
  }

  /// For integrators: the state reached by integration, which continues the solution.
  void continue_at(const State& x) noexcept SEXTANT_NONBLOCKING {
    x_ = x;
    if constexpr (moves_link_voltage<Appended>) {
      note_link_voltage();
      inverter_.set_link_voltage(u_dc());
    }
  }
  [[nodiscard]] const State& state() const noexcept SEXTANT_NONBLOCKING { return x_; }
  /// Those of x that are the states of a part of the appended system.
  template <class Part>
    requires has_part<Part, Appended>
  [[nodiscard]] static auto states_of(const State& x) noexcept SEXTANT_NONBLOCKING {
    constexpr auto length = std::size_t(Part::size);
    return std::span<const T, length>{x.data() + machine_size + part_begin<Part, Appended>(), length};
  }
  [[nodiscard]] std::uint64_t revision() const noexcept SEXTANT_NONBLOCKING { return revision_; }
  /// Changes whenever the state jumps, or the right-hand side does by anything but the voltage of a bridge
  /// whose legs are all driven, the load torque or the imposed slope of the speed.
  [[nodiscard]] std::uint64_t jumps() const noexcept SEXTANT_NONBLOCKING { return jumps_; }

  /// The right-hand side, dx/dt at x.
  void derivative(const State& x, State& dx) const noexcept SEXTANT_NONBLOCKING {
    if (inverter_.voltage_is_fixed()) return fixed_derivative(x, dx);
    derivative_at<true>(
        x, dx, [this, &x](SpaceVector<T> dpsi_r, SpaceVector<T> i_s) noexcept SEXTANT_NONBLOCKING {
          return inverter_at(x).voltage_map()(machine_.emf(dpsi_r, stator_flux(x), rotor_flux(x), i_s));
        });
  }
  /// The same while no leg floats, for integrators that check this once a step.
  void fixed_derivative(const State& x, State& dx) const noexcept SEXTANT_NONBLOCKING {
    if (drops_.threshold_voltage == T(0)) return driven_derivative(x, dx);
    derivative_at<true>(x, dx, [this, &x](SpaceVector<T>, SpaceVector<T>) noexcept SEXTANT_NONBLOCKING {
      return fixed_voltage(x);
    });
  }
  /// The same while the inverter has no threshold either.
  void driven_derivative(const State& x, State& dx) const noexcept SEXTANT_NONBLOCKING {
    derivative_at(x, dx, [this, &x](SpaceVector<T>, SpaceVector<T>) noexcept SEXTANT_NONBLOCKING {
      return fixed_voltage(x);
    });
  }

  /// The slope of fluxes, speed and angle at x without the stator voltage: where every leg is driven,
  ///   dx/dt = undriven_derivative(x) + (u_s, 0, 0, 0).
  void undriven_derivative(const MachineState& x, MachineState& dx) const noexcept SEXTANT_NONBLOCKING {
    derivative_at(
        x, dx, [](SpaceVector<T>, SpaceVector<T>) noexcept SEXTANT_NONBLOCKING { return SpaceVector<T>{}; });
  }
  /// The quantities at x but stator voltage, link current and what thresholds take, which the inverter
  /// decides.
  [[nodiscard]] PlantQuantities<T> quantities(const MachineState& x) const noexcept SEXTANT_NONBLOCKING {
    PlantQuantities<T> q;
    q.psi_s = stator_flux(x);
    q.psi_r = rotor_flux(x);
    q.i_s = machine_.stator_current(q.psi_s, q.psi_r);
    q.i_r = machine_.rotor_current(q.psi_s, q.psi_r);
    q.u_dc = inputs_.u_dc;
    q.tau_e = machine_.torque(q.psi_s, q.i_s);
    q.tau_l = inputs_.tau_l;
    q.omega_m = x[omega];
    q.theta_m = x[theta];
    q.u_given = inputs_.u_dc;
    q.tau_given = inputs_.tau_l;
    if (machine_.has_iron_loss()) [[unlikely]]
      q.iron_loss = part_iron(q.psi_r, q.omega_m, q.i_r, q.tau_e);
    return q;
  }
  /// The same of the whole state, with the inputs that act there.
  [[nodiscard]] PlantQuantities<T> quantities_at(const State& x) const noexcept SEXTANT_NONBLOCKING {
    PlantQuantities<T> q = quantities(MachineState{x.template head<machine_size>()});
    const PlantInputs<T>& acting = inputs_at(x);
    q.u_dc = acting.u_dc;
    q.tau_l = acting.tau_l;
    return q;
  }
  /// The slope of an appended system of integrals under leg states that are all driven; q: of `quantities`,
  /// gets stator voltage and link current.
  [[nodiscard]] Integrals integral_derivative(PlantQuantities<T>& q,
                                              SwitchState state) const noexcept SEXTANT_NONBLOCKING
    requires(is_integral<Appended>)
  {
    Integrals dy{};
    q.u_s = stator_voltage(state, inputs_.u_dc);
    q.i_dc = sextant::dc_link_current(state, inverse_clarke(q.i_s));
    // What it is an integral of does not depend on it.
    appended_.derivative(q, Integrals{}, dy);
    return dy;
  }

  /// d²omega_m/dt² at x, whose derivative is dx; of a linear machine, whose torque is bilinear in the
  /// fluxes. [rad/s³]
  [[nodiscard]] T speed_curvature(const State& x, const State& dx) const noexcept SEXTANT_NONBLOCKING {
    if (inputs_.imposed_speed) return T(0);
    const SpaceVector<T> i_s = machine_.stator_current(stator_flux(x), rotor_flux(x));
    const SpaceVector<T> di_s = machine_.stator_current(stator_flux(dx), rotor_flux(dx));
    T slope = machine_.torque(stator_flux(dx), i_s) + machine_.torque(stator_flux(x), di_s) -
              viscous_friction_ * dx[omega];
    if (feels_road_) [[unlikely]]
      slope -= road_load_.slope(x[omega]) * dx[omega];
    return slope * inverse_inertia_;
  }

  /// How fast the fluxes move at the present speed: the eigenvalues of their equations are no larger. [1/s]
  [[nodiscard]] T electrical_rate() const noexcept SEXTANT_NONBLOCKING {
    return machine_.damping(psi_s(), psi_r()) + std::abs(machine_.pole_pairs() * x_[omega]);
  }
  /// How fast torque and speed oscillate against each other at the present fluxes, squared: at most
  ///   angle_gain |psi_s| |psi_r| / (J + J_road),
  /// by the slope of the torque by the rotor's angle; 0 where the speed is imposed. [1/s²]
  [[nodiscard]] T shaft_rate_squared() const noexcept SEXTANT_NONBLOCKING {
    if (inputs_.imposed_speed) return T(0);
    const T gain = T(0.5) * machine_.angle_gain(psi_s(), psi_r()) * inverse_inertia_;
    return gain * (dot(psi_s(), psi_s()) + dot(psi_r(), psi_r()));
  }
  /// How fast an appended system that feeds back moves, squared. [1/s²]
  [[nodiscard]] T appended_rate_squared() const noexcept SEXTANT_NONBLOCKING
    requires(feeds_back)
  {
    return appended_.rate_squared();
  }

  /// False when the state is not finite, when an appended system is not valid, or when the stator flux
  /// linkage is larger than the DC link can make it, whatever the speed does:
  ///   d|psi_r|/dt ≤ L_m/L_s |psi_s| R_r/σL_r − |psi_r| R_r/σL_r  and
  ///   d|psi_s|/dt ≤ |u_s| − R_s/σL_s (|psi_s| − k_r |psi_r|)  give  |psi_s| ≤ L_s/R_s |u_s|,
  /// |u_s| ≤ 2/3 (u_dc + 2 V_t), with largest link voltage and smallest R_s so far; with saturation L_s is
  /// the largest one, and iron loss makes d|psi_r|/dt smaller. An integration that goes beyond it has left
  /// the machine's equations.
  [[nodiscard]] bool is_reachable() const noexcept SEXTANT_NONBLOCKING {
    if constexpr (feeds_back) {
      if (!appended_.is_valid(appended_states(x_))) return false;
    }
    const T limit = flux_per_volt_ * largest_u_dc_;
    return dot(psi_s(), psi_s()) <= limit * limit && std::isfinite(x_.sum());
  }

  /// ∂(dx/dt)/∂x at x. While a leg floats, the stator voltage counts as that of the machine without
  /// saturation, with which a Newton iteration takes more steps to the same solution. The rows of an appended
  /// system without feedback are left at zero: nothing depends on it, so that a Newton iteration loses one
  /// step there and no accuracy. With feedback, and of a machine without `InductionEquations`, all are
  /// difference quotients.
  void jacobian(const State& x, Jacobian& j) const noexcept SEXTANT_NONBLOCKING;

  /// Event functions of the three inverter legs, and of an appended system that feeds back; an event is a
  /// fall through zero.
  void events(const State& x, Events& g) const noexcept SEXTANT_NONBLOCKING {
    if (inverter_.voltage_is_fixed()) return fixed_events(x, g);
    put_events(x, inverter_at(x).events(machine_.stator_current(stator_flux(x), rotor_flux(x)), emf_at(x)),
               g);
  }
  /// The same while no leg floats.
  void fixed_events(const State& x, Events& g) const noexcept SEXTANT_NONBLOCKING {
    put_events(x, inverter_.current_events(machine_.stator_current(stator_flux(x), rotor_flux(x))), g);
  }
  /// What the inverter's thresholds take of the stator voltage while no current changes its sign, V_t in the
  /// direction of each current. [V]
  [[nodiscard]] SpaceVector<T> threshold_voltage() const noexcept SEXTANT_NONBLOCKING {
    if (drops_.threshold_voltage == T(0)) return {};
    const auto lost = [this](T i) { return i < T(0) ? -drops_.threshold_voltage : drops_.threshold_voltage; };
    const ThreePhase<T> i = i_abc();
    return clarke(ThreePhase<T>{lost(i.a), lost(i.b), lost(i.c)});
  }
  /// True where segments with legs off may be `TiedSegments`: no cable is open.
  [[nodiscard]] bool may_be_tied() const noexcept SEXTANT_NONBLOCKING {
    return inverter_.open_phase() == Inverter<T>::no_phase;
  }
  /// True when the stator voltage over all of these gate segments follows from them alone.
  [[nodiscard]] bool is_driven_by(std::span<const GateSegment> segments) const noexcept SEXTANT_NONBLOCKING {
    return !feeds_back && inverter_.is_plain() && !inputs_.duties &&
           std::all_of(segments.begin(), segments.end(),
                       [](const GateSegment& segment) { return is_driven(segment.state); });
  }
  /// True while events can come: a leg is off, a cable open or a threshold to be overcome, or an appended
  /// system feeds back.
  [[nodiscard]] bool has_events() const noexcept SEXTANT_NONBLOCKING {
    return feeds_back || inverter_.has_events();
  }
  /// An event has come at the present state.
  void on_event(int event) noexcept SEXTANT_NONBLOCKING {
    if (event < Inverter<T>::event_count) {
      inverter_.on_event(event, i_s(), emf_at(x_));
      make_current_admissible();
    }
    if constexpr (feeds_back) {
      if (event >= Inverter<T>::event_count)
        appended_.on_event(event - Inverter<T>::event_count, appended_states());
      settle_appended();
    }
    note_jump();
  }

  [[nodiscard]] SpaceVector<T> psi_s() const noexcept SEXTANT_NONBLOCKING { return stator_flux(x_); }
  [[nodiscard]] SpaceVector<T> psi_r() const noexcept SEXTANT_NONBLOCKING { return rotor_flux(x_); }
  [[nodiscard]] SpaceVector<T> i_s() const noexcept SEXTANT_NONBLOCKING {
    return machine_.stator_current(psi_s(), psi_r());
  }
  /// The same at another state.
  [[nodiscard]] SpaceVector<T> stator_current(const State& x) const noexcept SEXTANT_NONBLOCKING {
    return machine_.stator_current(stator_flux(x), rotor_flux(x));
  }
  /// Phase currents, positive into the machine. [A]
  [[nodiscard]] ThreePhase<T> i_abc() const noexcept SEXTANT_NONBLOCKING { return inverse_clarke(i_s()); }
  /// Stator voltage at this instant, in front of the inverter's slope resistance. [V]
  [[nodiscard]] SpaceVector<T> u_s() const noexcept SEXTANT_NONBLOCKING {
    return inverter_.voltage_map()(emf_at(x_));
  }
  /// Voltage of the DC link. [V]
  [[nodiscard]] T u_dc() const noexcept SEXTANT_NONBLOCKING { return inputs_at(x_).u_dc; }
  /// What of these inputs acts at the present state.
  [[nodiscard]] PlantInputs<T> acting(PlantInputs<T> given) const noexcept SEXTANT_NONBLOCKING {
    if constexpr (feeds_back) appended_.act(appended_states(x_), x_[omega], given);
    return given;
  }
  /// Current drawn from the DC link. [A]
  [[nodiscard]] T i_dc() const noexcept SEXTANT_NONBLOCKING { return inverter_.dc_link_current(i_s()); }
  /// Electromagnetic torque. [N·m]
  [[nodiscard]] T tau_e() const noexcept SEXTANT_NONBLOCKING {
    const T tau_e = machine_.torque(psi_s(), i_s());
    if (!machine_.has_iron_loss()) [[likely]]
      return tau_e;
    return tau_e + machine_.iron_branch(machine_.rotor_current(psi_s(), psi_r()), psi_r(), omega_m()).torque;
  }
  /// Torque of the vehicle on the shaft, opposing positive rotation; zero where there is none. [N·m]
  [[nodiscard]] T tau_road() const noexcept SEXTANT_NONBLOCKING {
    return feels_road_ ? road_load_.torque(x_[omega]) : T(0);
  }
  /// The same at a mechanical speed [rad/s], also where the speed is imposed. [N·m]
  [[nodiscard]] T tau_road_at(T speed) const noexcept SEXTANT_NONBLOCKING { return road_load_.torque(speed); }
  /// Mechanical speed. [rad/s]
  [[nodiscard]] T omega_m() const noexcept SEXTANT_NONBLOCKING { return x_[omega]; }
  /// Mechanical angle, not wrapped. [rad]
  [[nodiscard]] T theta_m() const noexcept SEXTANT_NONBLOCKING { return x_[theta]; }
  /// Energy of the magnetic field. [J]
  [[nodiscard]] T magnetic_energy() const noexcept SEXTANT_NONBLOCKING {
    return machine_.magnetic_energy(psi_s(), psi_r());
  }
  [[nodiscard]] const Machine& machine() const noexcept SEXTANT_NONBLOCKING { return machine_; }
  [[nodiscard]] const Inverter<T>& inverter() const noexcept SEXTANT_NONBLOCKING { return inverter_; }
  [[nodiscard]] const ConductionDrops<T>& drops() const noexcept SEXTANT_NONBLOCKING { return drops_; }
  [[nodiscard]] const Appended& appended_system() const noexcept SEXTANT_NONBLOCKING { return appended_; }
  /// The same, to change its inputs; integrators restart.
  [[nodiscard]] Appended& appended_system() noexcept SEXTANT_NONBLOCKING {
    ++revision_;
    return appended_;
  }

 private:
  static constexpr std::size_t appended_size = std::size_t(Appended::size);
  /// By which the largest flux may be passed without a reason.
  static constexpr T rounding = T(1e-3);

  template <class Vector>
  static SpaceVector<T> stator_flux(const Vector& x) noexcept SEXTANT_NONBLOCKING {
    return {x[psi_s_alpha], x[psi_s_beta]};
  }
  template <class Vector>
  static SpaceVector<T> rotor_flux(const Vector& x) noexcept SEXTANT_NONBLOCKING {
    return {x[psi_r_alpha], x[psi_r_beta]};
  }
  /// The machine's parameters with the inverter's slope resistance in series.
  static InductionMachineParameters<T> in_series(const DrivePlantParameters<T>& parameters) noexcept {
    InductionMachineParameters<T> m = parameters.machine;
    m.r_s += parameters.drops.slope_resistance;
    return m;
  }
  void begin(const InitialState<T>& initial) noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> psi_r{initial.rotor_flux, T(0)};
    const SpaceVector<T> psi_s = machine_.stator_flux({}, psi_r);
    x_[psi_s_alpha] = psi_s.alpha;
    x_[psi_s_beta] = psi_s.beta;
    x_[psi_r_alpha] = psi_r.alpha;
    x_[omega] = initial.speed;
    if constexpr (feeds_back) appended_.begin(appended_states(), initial.speed);
  }
  void note_jump() noexcept SEXTANT_NONBLOCKING {
    ++revision_;
    ++jumps_;
  }
  void note_stator_resistance() noexcept SEXTANT_NONBLOCKING {
    flux_per_volt_ =
        std::max(flux_per_volt_, (T(1) + rounding) * T(2) / T(3) * machine_.largest_inductance() /
                                     machine_.stator_resistance());
  }
  void note_link_voltage() noexcept SEXTANT_NONBLOCKING {
    const T highest = std::max(u_dc(), inputs_.u_dc);  // of a link and its source, which charges it
    largest_u_dc_ = std::max(largest_u_dc_, highest + T(2) * drops_.threshold_voltage);
  }
  /// The appended system's part of a state.
  static std::span<const T, appended_size> appended_states(const State& x) noexcept SEXTANT_NONBLOCKING {
    return std::span<const T, appended_size>{x.data() + machine_size, appended_size};
  }
  std::span<T, appended_size> appended_states() noexcept SEXTANT_NONBLOCKING {
    return std::span<T, appended_size>{x_.data() + machine_size, appended_size};
  }
  void settle_appended() noexcept SEXTANT_NONBLOCKING
    requires(feeds_back)
  {
    if (appended_.settle(appended_states(), x_[omega], inputs_)) note_jump();
  }
  /// The inputs that act at x: as they are set, or as an appended system changes them. Without its states, x
  /// being that of the machine, as they are set.
  template <class Vector>
  [[nodiscard]] decltype(auto) inputs_at(const Vector& x) const noexcept SEXTANT_NONBLOCKING {
    if constexpr (feeds_back && Vector::RowsAtCompileTime > machine_size) {
      PlantInputs<T> inputs = inputs_;
      appended_.act(appended_states(x), x[omega], inputs);
      return inputs;
    } else {
      return (inputs_);
    }
  }
  /// The inverter at x, under the ties that there are.
  template <class Vector>
  [[nodiscard]] decltype(auto) inverter_at(const Vector& x) const noexcept SEXTANT_NONBLOCKING {
    if constexpr (moves_link_voltage<Appended>) {
      Inverter<T> inverter = inverter_;
      inverter.set_link_voltage(inputs_at(x).u_dc);
      return inverter;
    } else {
      return (inverter_);
    }
  }
  /// Event functions at x, with those of the legs.
  void put_events(const State& x, const std::array<T, 3>& legs,
                  Events& g) const noexcept SEXTANT_NONBLOCKING {
    std::copy(legs.begin(), legs.end(), g.begin());
    if constexpr (feeds_back)
      appended_.events(appended_states(x), x[omega], inputs_, std::span{g}.template subspan<3>());
  }
  /// The stator voltage at x while no leg floats. [V]
  [[nodiscard]] SpaceVector<T> fixed_voltage(const State& x) const noexcept SEXTANT_NONBLOCKING {
    if constexpr (moves_link_voltage<Appended>)
      return inverter_.fixed_voltage(inputs_at(x).u_dc);
    else
      return inverter_.voltage_map().offset;
  }
  static Machine machine_of(const DrivePlantParameters<T>& parameters) {
    if constexpr (std::constructible_from<Machine, InductionMachineParameters<T>, SaturationParameters<T>,
                                          IronLossParameters<T>, MagnetisingPoints<T>, LeakageSaturation<T>>)
      return Machine{in_series(parameters), parameters.saturation, parameters.iron_loss, parameters.points,
                     parameters.leakage};
    else if constexpr (std::constructible_from<Machine, InductionMachineParameters<T>,
                                               SaturationParameters<T>>)
      return Machine{in_series(parameters), parameters.saturation};
    else
      return Machine{in_series(parameters)};
  }
  /// x: the whole state, or that of the machine. stator_voltage: u_s by dpsi_r/dt and i_s. has_threshold:
  /// whether the inverter may have one.
  template <bool has_threshold = false, class Vector, class StatorVoltage>
  void derivative_at(const Vector& x, Vector& dx,
                     const StatorVoltage& stator_voltage) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> flux_s = stator_flux(x);
    const SpaceVector<T> flux_r = rotor_flux(x);
    const SpaceVector<T> i_s = machine_.stator_current(flux_s, flux_r);
    SpaceVector<T> i_r = machine_.rotor_current(flux_s, flux_r);
    const SpaceVector<T> dpsi_r = machine_.rotor_flux_derivative(i_r, flux_r, x[omega]);
    const SpaceVector<T> u_s = stator_voltage(dpsi_r, i_s);
    const SpaceVector<T> dpsi_s = machine_.stator_flux_derivative(u_s, i_s);
    T tau_e = machine_.torque(flux_s, i_s);
    T iron_loss{};
    if (machine_.has_iron_loss()) [[unlikely]]
      iron_loss = part_iron(flux_r, x[omega], i_r, tau_e);
    const PlantInputs<T>& acting = inputs_at(x);
    dx[psi_s_alpha] = dpsi_s.alpha;
    dx[psi_s_beta] = dpsi_s.beta;
    dx[psi_r_alpha] = dpsi_r.alpha;
    dx[psi_r_beta] = dpsi_r.beta;
    dx[omega] = acting.imposed_speed
                    ? acting.speed_slope
                    : (tau_e - acting.tau_l - viscous_friction_ * x[omega]) * inverse_inertia_;
    if (feels_road_) [[unlikely]]
      dx[omega] -= road_load_.torque(x[omega]) * inverse_inertia_;
    dx[theta] = x[omega];
    if constexpr (Vector::RowsAtCompileTime > machine_size) {
      const T threshold_loss = has_threshold ? drops_.threshold_loss(i_s) : T(0);
      const PlantQuantities<T> q{flux_s,
                                 flux_r,
                                 i_s,
                                 i_r,
                                 u_s,
                                 acting.u_dc,
                                 inverter_.dc_link_current(i_s),
                                 tau_e,
                                 acting.tau_l,
                                 x[omega],
                                 x[theta],
                                 iron_loss,
                                 threshold_loss,
                                 inputs_.u_dc,
                                 inputs_.tau_l,
                                 inputs_.inverter_loss};
      appended_.derivative(q, std::span<const T, appended_size>{x.data() + machine_size, appended_size},
                           std::span<T, appended_size>{dx.data() + machine_size, appended_size});
    }
  }
  /// Takes the iron's share from the current of rotor and iron [A] and from the torque [N·m]; its loss. [W]
  [[nodiscard]] T part_iron(SpaceVector<T> flux_r, T omega_m, SpaceVector<T>& i_r,
                            T& tau_e) const noexcept SEXTANT_NONBLOCKING {
    const auto branch = machine_.iron_branch(i_r, flux_r, omega_m);
    i_r = branch.i_r;
    tau_e += branch.torque;
    return branch.power;
  }
  BackEmf<T> emf_at(const State& x) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> flux_s = stator_flux(x);
    const SpaceVector<T> flux_r = rotor_flux(x);
    const SpaceVector<T> i_r = machine_.rotor_current(flux_s, flux_r);
    return machine_.emf(machine_.rotor_flux_derivative(i_r, flux_r, x[omega]), flux_s, flux_r,
                        machine_.stator_current(flux_s, flux_r));
  }
  using Block = Eigen::Matrix<T, 2, 2>;
  using Column = Eigen::Matrix<T, 2, 1>;
  /// ∂(dpsi_r/dt)/∂(psi_s, psi_r, omega_m), and by the same what iron loss adds to the torque.
  struct RotorSlopes {
    Block by_stator, by_rotor;
    Column by_speed;
    Eigen::Matrix<T, 1, 5> iron_torque{Eigen::Matrix<T, 1, 5>::Zero()};
  };
  /// i_s = (psi_s − k_r psi_r)/σL_s, i_r = psi_r/L_r − k_r i_s
  [[nodiscard]] RotorSlopes rotor_slopes(const State& x) const noexcept SEXTANT_NONBLOCKING {
    const InductionMachineParameters<T>& m = machine_.parameters();
    const T p = T(m.pole_pairs);
    const T k_r = m.k_r();
    const T inverse_sigma_l_s = T(1) / m.sigma_l_s();
    const SpaceVector<T> r = rotor_flux(x);
    Block turn;
    turn << T(0), T(-1), T(1), T(0);
    RotorSlopes slopes;
    slopes.by_stator = m.r_r * k_r * inverse_sigma_l_s * Block::Identity();
    slopes.by_rotor =
        (p * x[omega]) * turn - m.r_r * (T(1) / m.l_r() + k_r * k_r * inverse_sigma_l_s) * Block::Identity();
    slopes.by_speed = Column{-p * r.beta, p * r.alpha};
    if (machine_.has_saturated_leakage()) {
      const Block by_current = m.r_r * machine_.gamma() * added_leakage(x);
      slopes.by_stator += by_current;
      slopes.by_rotor -= machine_.gamma() * by_current;
    }
    if (machine_.has_iron_loss()) add_iron_loss(x, slopes);
    return slopes;
  }
  /// From the slopes of f to those of dpsi_r/dt (`IronLoss`), and of the torque 3/2 p/R_r (f − dpsi_r/dt) ×
  /// psi_r.
  void add_iron_loss(const State& x, RotorSlopes& slopes) const noexcept SEXTANT_NONBLOCKING {
    const InductionMachineParameters<T>& m = machine_.parameters();
    const SpaceVector<T> r = rotor_flux(x);
    const SpaceVector<T> i_r = machine_.rotor_current(stator_flux(x), r);
    const T p = T(m.pole_pairs);
    const SpaceVector<T> f = (p * x[omega]) * rotate_90(r) - m.r_r * i_r;
    const SpaceVector<T> lost = f - machine_.rotor_flux_derivative(i_r, r, x[omega]);
    const auto by = machine_.iron_slopes(f, r);
    const SpaceVector<T> unit = direction(f);
    const SpaceVector<T> unit_r = direction(r);
    const Column along{unit.alpha, unit.beta};
    const Block passed = by.across * Block::Identity() + (by.along - by.across) * along * along.transpose();
    const RotorSlopes before = slopes;
    slopes.by_stator = passed * before.by_stator;
    slopes.by_rotor =
        passed * before.by_rotor + by.by_flux * along * Column{unit_r.alpha, unit_r.beta}.transpose();
    slopes.by_speed = passed * before.by_speed;
    const Eigen::Matrix<T, 1, 2> times_flux{r.beta, -r.alpha};
    const T gain = T(1.5) * p / m.r_r;
    slopes.iron_torque << times_flux * (before.by_stator - slopes.by_stator),
        times_flux * (before.by_rotor - slopes.by_rotor), times_flux * (before.by_speed - slopes.by_speed);
    slopes.iron_torque[psi_r_alpha] -= lost.beta;
    slopes.iron_torque[psi_r_beta] += lost.alpha;
    slopes.iron_torque *= gain;
  }
  /// −R_s di_s/dpsi_s beyond that of the linear machine.
  void add_saturation(SpaceVector<T> flux_s, SpaceVector<T> flux_r,
                      Jacobian& j) const noexcept SEXTANT_NONBLOCKING {
    const InductionMachineParameters<T>& m = machine_.parameters();
    const InverseInductance<T> inverse = machine_.inverse_inductance(flux_s, flux_r);
    const T square = dot(inverse.axis, inverse.axis);
    const T along = square > T(0) ? m.r_s * inverse.added_along / square : T(0);
    const Column axis{inverse.axis.alpha, inverse.axis.beta};
    j.template block<2, 2>(0, 0) -=
        m.r_s * (inverse.across - T(1) / m.sigma_l_s()) * Block::Identity() + along * axis * axis.transpose();
  }
  /// What saturation of the leakage adds besides to stator flux and torque, −3/2 p gamma g (psi_s × psi_r)
  /// with the g of `added_leakage` across.
  void add_leakage(const State& x, Jacobian& j) const noexcept SEXTANT_NONBLOCKING {
    const InductionMachineParameters<T>& m = machine_.parameters();
    const SpaceVector<T> s = stator_flux(x), r = rotor_flux(x);
    j.template block<2, 2>(0, 2) += m.r_s * machine_.gamma() * added_leakage(x);
    if (inputs_.imposed_speed) return;
    const InverseInductance<T> added = machine_.added_leakage(s, r);
    const SpaceVector<T> along = added.axis;
    const T square = dot(along, along);
    const T bend = square > T(0) ? cross(s, r) * added.added_along / square : T(0);
    const T gain = T(-1.5) * T(m.pole_pairs) * machine_.gamma() * inverse_inertia_;
    j(omega, psi_s_alpha) += gain * (added.across * r.beta + bend * along.alpha);
    j(omega, psi_s_beta) += gain * (-added.across * r.alpha + bend * along.beta);
    j(omega, psi_r_alpha) -= gain * (added.across * s.beta + machine_.gamma() * bend * along.alpha);
    j(omega, psi_r_beta) -= gain * (-added.across * s.alpha + machine_.gamma() * bend * along.beta);
  }
  [[nodiscard]] Block added_leakage(const State& x) const noexcept SEXTANT_NONBLOCKING {
    return block_of(machine_.added_leakage(stator_flux(x), rotor_flux(x)));
  }
  [[nodiscard]] static Block block_of(const InverseInductance<T>& inverse) noexcept SEXTANT_NONBLOCKING {
    const T square = dot(inverse.axis, inverse.axis);
    const Column axis{inverse.axis.alpha, inverse.axis.beta};
    const T along = square > T(0) ? inverse.added_along / square : T(0);
    return inverse.across * Block::Identity() + along * axis * axis.transpose();
  }
  void settle_inverter() noexcept SEXTANT_NONBLOCKING {
    if (inputs_.duties) [[unlikely]]
      return inverter_.set_mean(*inputs_.duties, inputs_.state, u_dc(), i_s());
    if (inverter_.is_plain() && is_driven(inputs_.state)) return inverter_.set_driven(inputs_.state, u_dc());
    inverter_.set(inputs_.state, u_dc(), i_s(), emf_at(x_));
    make_current_admissible();
  }
  void make_current_admissible() noexcept SEXTANT_NONBLOCKING {
    if (!inverter_.has_idle_legs()) return;
    const SpaceVector<T> flux = machine_.stator_flux(inverter_.admissible_current(i_s()), psi_r());
    x_[psi_s_alpha] = flux.alpha;
    x_[psi_s_beta] = flux.beta;
  }

  /// ∂(dx/dt)/∂x by the machine's parameters.
  void analytic_jacobian(const State& x, Jacobian& j) const noexcept SEXTANT_NONBLOCKING;
  /// Of a system that feeds back, or of another machine: ∂(dx/dt)/∂x by central differences, as a Newton
  /// iteration needs it.
  void difference_quotients(const State& x, Jacobian& j) const noexcept SEXTANT_NONBLOCKING;

  Machine machine_;
  Appended appended_;
  T inverse_inertia_;   ///< 1/(J + J_road) [1/(kg·m²)]
  T viscous_friction_;  ///< B [N·m·s/rad]
  RoadLoad<T> road_load_;
  bool on_road_;       ///< the road load is not zero
  bool feels_road_;    ///< and the speed is not imposed
  T flux_per_volt_{};  ///< largest |psi_s| by u_dc, with the smallest R_s so far [s]
  T largest_u_dc_{};   ///< of the inputs so far, with two thresholds [V]
  ConductionDrops<T> drops_;
  Inverter<T> inverter_;
  PlantInputs<T> inputs_{};
  State x_{State::Zero()};
  std::uint64_t revision_{1};
  std::uint64_t jumps_{1};
};

template <class T, class Appended, class Machine>
  requires AppendedSystem<Appended, T> && PlantMachine<Machine, T> &&
           (!feeds_back<Appended> || FeedbackSystem<Appended, T>)
void DrivePlant<T, Appended, Machine>::jacobian(const State& x,
                                                Jacobian& j) const noexcept SEXTANT_NONBLOCKING {
  if constexpr (feeds_back || !InductionEquations<Machine, T>)
    difference_quotients(x, j);
  else
    analytic_jacobian(x, j);
}

template <class T, class Appended, class Machine>
  requires AppendedSystem<Appended, T> && PlantMachine<Machine, T> &&
           (!feeds_back<Appended> || FeedbackSystem<Appended, T>)
void DrivePlant<T, Appended, Machine>::analytic_jacobian(const State& x,
                                                         Jacobian& j) const noexcept SEXTANT_NONBLOCKING {
  const InductionMachineParameters<T>& m = machine_.parameters();
  const T p = T(m.pole_pairs);
  const T k_r = m.k_r();
  const T inverse_sigma_l_s = T(1) / m.sigma_l_s();
  const SpaceVector<T> s = stator_flux(x);
  const SpaceVector<T> r = rotor_flux(x);
  const StatorVoltageMap<T>& map = inverter_.voltage_map();
  Block gain;  // of the EMF on the stator voltage
  gain << map.gain_alpha, map.gain_cross, map.gain_cross, map.gain_beta;
  const RotorSlopes rotor = rotor_slopes(x);

  j.setZero();
  j.template block<2, 2>(0, 0) = k_r * gain * rotor.by_stator - m.r_s * inverse_sigma_l_s * Block::Identity();
  j.template block<2, 2>(0, 2) =
      k_r * gain * rotor.by_rotor + m.r_s * k_r * inverse_sigma_l_s * Block::Identity();
  j.template block<2, 1>(0, 4) = k_r * gain * rotor.by_speed;
  if (!machine_.is_linear()) add_saturation(s, r, j);
  j.template block<2, 2>(2, 0) = rotor.by_stator;
  j.template block<2, 2>(2, 2) = rotor.by_rotor;
  j.template block<2, 1>(2, 4) = rotor.by_speed;
  j(theta, omega) = T(1);
  if (machine_.has_saturated_leakage()) add_leakage(x, j);
  if (inputs_.imposed_speed) return;

  // tau_e = 3/2 p k_r/σL_s (psi_r × psi_s)
  const T torque_gain = T(1.5) * p * k_r * inverse_sigma_l_s * inverse_inertia_;
  j(omega, psi_s_alpha) += -torque_gain * r.beta;
  j(omega, psi_s_beta) += torque_gain * r.alpha;
  j(omega, psi_r_alpha) += torque_gain * s.beta;
  j(omega, psi_r_beta) += -torque_gain * s.alpha;
  j(omega, omega) = -viscous_friction_ * inverse_inertia_;
  if (machine_.has_iron_loss()) j.template block<1, 5>(omega, 0) += inverse_inertia_ * rotor.iron_torque;
  if (on_road_) j(omega, omega) -= road_load_.slope(x[omega]) * inverse_inertia_;
}

template <class T, class Appended, class Machine>
  requires AppendedSystem<Appended, T> && PlantMachine<Machine, T> &&
           (!feeds_back<Appended> || FeedbackSystem<Appended, T>)
void DrivePlant<T, Appended, Machine>::difference_quotients(const State& x,
                                                            Jacobian& j) const noexcept SEXTANT_NONBLOCKING {
  // The cube root of the rounding error is the best step of a central difference.
  const T share = std::cbrt(std::numeric_limits<T>::epsilon());
  for (int c = 0; c < size; ++c) {
    State ahead = x, behind = x, rise, fall;
    const T h = share * std::max(T(1), std::abs(x[c]));
    ahead[c] += h;
    behind[c] -= h;
    derivative(ahead, rise);
    derivative(behind, fall);
    j.col(c) = (rise - fall) / (ahead[c] - behind[c]);
  }
}

}  // namespace sextant
