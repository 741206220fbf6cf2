#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <span>
#include <utility>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/two_level_inverter.hpp"
#include "sextant/plant/appended_system.hpp"
#include "sextant/plant/difference_quotients.hpp"
#include "sextant/plant/drive_plant_parameters.hpp"
#include "sextant/plant/drive_plant_state.hpp"
#include "sextant/plant/flux_bound.hpp"
#include "sextant/plant/induction_machine.hpp"
#include "sextant/plant/inverter.hpp"
#include "sextant/plant/motor_shaft.hpp"
#include "sextant/plant/plant_machine.hpp"

namespace sextant {

/// Inverter, machine, shaft (`MotorShaft`) and an appended system as one ordinary differential equation:
///   dpsi_s/dt, dpsi_r/dt   of the machine under the stator voltage u_s (`PlantMachine::evaluate`)
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
/// `Machine` is any `PlantMachine`; by default the induction machine, linear or with a main flux that
/// saturates. examples/pm_machine has another one.
template <class T = double, class Appended = NoAppendedSystem<T>, class Machine = InductionMachine<T>>
  requires AppendedSystem<Appended, T> && PlantMachine<Machine, T> &&
           (!feeds_back<Appended> || FeedbackSystem<Appended, T>)
class DrivePlant : public DrivePlantState<T, Appended> {
  using Layout = DrivePlantState<T, Appended>;

 public:
  using Scalar = T;
  using AppendedType = Appended;
  static constexpr bool appends_integrals = is_integral<Appended>;
  static constexpr bool feeds_back = sextant::feeds_back<Appended>;
  using Layout::machine_size, Layout::size, Layout::omega, Layout::theta;
  using typename Layout::Integrals, typename Layout::Jacobian, typename Layout::MachineState,
      typename Layout::State;
  /// The last state has no say in the steps of an integrator with error control.
  static constexpr bool last_is_uncontrolled = sextant::last_is_uncontrolled<Appended>;
  static constexpr int event_count = Inverter<T>::event_count + appended_event_count<Appended>;
  using Events = std::array<T, std::size_t(event_count)>;

  /// In the initial state of the parameters, gates off. The parameters must be valid.
  explicit DrivePlant(const DrivePlantParameters<T>& parameters, Appended appended_system = Appended{})
    requires std::constructible_from<Machine, const DrivePlantParameters<T>&>
      : DrivePlant{parameters, std::move(appended_system), Machine{parameters}} {}

  /// The same with a machine that has other parameters than `parameters`; its stator resistance has the
  /// inverter's slope resistance in it.
  DrivePlant(const DrivePlantParameters<T>& parameters, Appended appended_system, const Machine& machine)
      : machine_{machine},
        appended_{std::move(appended_system)},
        shaft_{parameters.machine.inertia, parameters.viscous_friction, parameters.road_load},
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
    shaft_.impose_speed(inputs.imposed_speed);
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
  void set_resistances(T r_s, T r_r) noexcept SEXTANT_NONBLOCKING
    requires HeatedMachine<Machine, T>
  {
    if (r_s == machine_.stator_resistance() && r_r == machine_.rotor_resistance()) return;
    machine_.set_resistances(r_s, r_r);
    note_stator_resistance();
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
    Layout::put_fluxes({stator, rotor}, x);
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
  [[nodiscard]] std::uint64_t revision() const noexcept SEXTANT_NONBLOCKING { return revision_; }
  /// Changes whenever the state jumps, or the right-hand side does by anything but the voltage of a bridge
  /// whose legs are all driven, the load torque or the imposed slope of the speed.
  [[nodiscard]] std::uint64_t jumps() const noexcept SEXTANT_NONBLOCKING { return jumps_; }

  /// The right-hand side, dx/dt at x.
  void derivative(const State& x, State& dx) const noexcept SEXTANT_NONBLOCKING {
    if (inverter_.voltage_is_fixed()) return fixed_derivative(x, dx);
    derivative_at<true>(x, dx, inverter_at(x).voltage_map()(emf_at(x)));
  }
  /// The same while no leg floats, for integrators that check this once a step.
  void fixed_derivative(const State& x, State& dx) const noexcept SEXTANT_NONBLOCKING {
    if (drops_.threshold_voltage == T(0)) return driven_derivative(x, dx);
    derivative_at<true>(x, dx, fixed_voltage(x));
  }
  /// The same while the inverter has no threshold either.
  void driven_derivative(const State& x, State& dx) const noexcept SEXTANT_NONBLOCKING {
    derivative_at(x, dx, fixed_voltage(x));
  }

  /// The slope of fluxes, speed and angle at x without the stator voltage: where every leg is driven,
  ///   dx/dt = undriven_derivative(x) + (u_s, 0, 0, 0).
  void undriven_derivative(const MachineState& x, MachineState& dx) const noexcept SEXTANT_NONBLOCKING {
    derivative_at(x, dx, SpaceVector<T>{});
  }
  /// The machine at x without its stator voltage.
  [[nodiscard]] MachineEvaluation<T> evaluate(const State& x) const noexcept SEXTANT_NONBLOCKING {
    return machine_.evaluate(Layout::fluxes(x), {}, x[omega]);
  }
  /// The quantities at x but stator voltage, link current and what thresholds take, which the inverter
  /// decides.
  [[nodiscard]] PlantQuantities<T> quantities(const MachineState& x) const noexcept SEXTANT_NONBLOCKING {
    return quantities_of(machine_.evaluate(Layout::fluxes(x), {}, x[omega]), x, inputs_);
  }
  /// The same of the whole state, with the inputs that act there.
  [[nodiscard]] PlantQuantities<T> quantities_at(const State& x) const noexcept SEXTANT_NONBLOCKING {
    return quantities_of(evaluate(x), x, inputs_at(x));
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

  /// d²omega_m/dt² at x, whose derivative is dx; of a linear machine. [rad/s³]
  [[nodiscard]] T speed_curvature(const State& x, const State& dx) const noexcept SEXTANT_NONBLOCKING
    requires LinearEquations<Machine, T>
  {
    if (inputs_.imposed_speed) return T(0);
    return shaft_.curvature(machine_.torque_slope(Layout::fluxes(x), Layout::fluxes(dx)), x[omega],
                            dx[omega]);
  }

  /// What `LinearEquations` has of the machine; one without is not linear, and its rates are zero.
  [[nodiscard]] bool is_linear() const noexcept SEXTANT_NONBLOCKING {
    if constexpr (LinearEquations<Machine, T>)
      return machine_.is_linear();
    else
      return false;
  }
  [[nodiscard]] ElectricalRates<T> electrical_rates() const noexcept SEXTANT_NONBLOCKING {
    if constexpr (LinearEquations<Machine, T>)
      return machine_.electrical_rates();
    else
      return {};
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
    const T gain = T(0.5) * machine_.angle_gain(psi_s(), psi_r()) * shaft_.inverse_inertia();
    return gain * (dot(psi_s(), psi_s()) + dot(psi_r(), psi_r()));
  }
  /// How fast an appended system that feeds back moves, squared. [1/s²]
  [[nodiscard]] T appended_rate_squared() const noexcept SEXTANT_NONBLOCKING
    requires(feeds_back)
  {
    return appended_.rate_squared();
  }

  /// False when the state is not finite, when an appended system is not valid, or when the stator flux
  /// linkage is beyond its `FluxBound`.
  [[nodiscard]] bool is_reachable() const noexcept SEXTANT_NONBLOCKING {
    if constexpr (feeds_back) {
      if (!appended_.is_valid(appended_states(x_))) return false;
    }
    return flux_bound_.holds(psi_s()) && std::isfinite(x_.sum());
  }

  /// ∂(dx/dt)/∂x at x. While a leg floats, the stator voltage follows from the share of the back-EMF that
  /// `MachineSlopes` has. The rows of an appended system without feedback are left at zero: nothing depends
  /// on it, so that a Newton iteration loses one step there and no accuracy. With feedback, and of a machine
  /// that is no `DifferentiatedMachine`, all are difference quotients.
  void jacobian(const State& x, Jacobian& j) const noexcept SEXTANT_NONBLOCKING {
    if constexpr (feeds_back || !DifferentiatedMachine<Machine, T>)
      difference_quotients(
          [this](const State& y, State& dy) noexcept SEXTANT_NONBLOCKING { derivative(y, dy); }, x, j);
    else
      analytic_jacobian(x, j);
  }

  /// Event functions of the three inverter legs, and of an appended system that feeds back; an event is a
  /// fall through zero.
  void events(const State& x, Events& g) const noexcept SEXTANT_NONBLOCKING {
    if (inverter_.voltage_is_fixed()) return fixed_events(x, g);
    const MachineEvaluation<T> e = evaluate(x);
    put_events(x, inverter_at(x).events(e.i_s, machine_.emf(Layout::fluxes(x), e)), g);
  }
  /// The same while no leg floats.
  void fixed_events(const State& x, Events& g) const noexcept SEXTANT_NONBLOCKING {
    put_events(x, inverter_.current_events(stator_current(x)), g);
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
        appended_.on_event(event - Inverter<T>::event_count, appended_states(x_));
      settle_appended();
    }
    note_jump();
  }

  [[nodiscard]] SpaceVector<T> psi_s() const noexcept SEXTANT_NONBLOCKING { return Layout::fluxes(x_).s; }
  [[nodiscard]] SpaceVector<T> psi_r() const noexcept SEXTANT_NONBLOCKING { return Layout::fluxes(x_).r; }
  [[nodiscard]] SpaceVector<T> i_s() const noexcept SEXTANT_NONBLOCKING { return stator_current(x_); }
  /// The same at another state.
  [[nodiscard]] SpaceVector<T> stator_current(const State& x) const noexcept SEXTANT_NONBLOCKING {
    return evaluate(x).i_s;
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
  [[nodiscard]] T tau_e() const noexcept SEXTANT_NONBLOCKING { return evaluate(x_).tau_e; }
  /// Torque of the vehicle on the shaft, opposing positive rotation; zero where there is none. [N·m]
  [[nodiscard]] T tau_road() const noexcept SEXTANT_NONBLOCKING { return shaft_.road_torque(x_[omega]); }
  /// The same at a mechanical speed [rad/s], also where the speed is imposed. [N·m]
  [[nodiscard]] T tau_road_at(T speed) const noexcept SEXTANT_NONBLOCKING {
    return shaft_.road_load().torque(speed);
  }
  /// Mechanical speed. [rad/s]
  [[nodiscard]] T omega_m() const noexcept SEXTANT_NONBLOCKING { return x_[omega]; }
  /// Mechanical angle, not wrapped. [rad]
  [[nodiscard]] T theta_m() const noexcept SEXTANT_NONBLOCKING { return x_[theta]; }
  /// Energy of the magnetic field. [J]
  [[nodiscard]] T magnetic_energy() const noexcept SEXTANT_NONBLOCKING { return evaluate(x_).field_energy; }
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
  using Layout::appended_states;

  [[nodiscard]] BackEmf<T> emf_at(const State& x) const noexcept SEXTANT_NONBLOCKING {
    return machine_.emf(Layout::fluxes(x), evaluate(x));
  }
  void begin(const InitialState<T>& initial) noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> psi_r{initial.rotor_flux, T(0)};
    const SpaceVector<T> psi_s = machine_.stator_flux({}, psi_r);
    Layout::put_fluxes({psi_s, psi_r}, x_);
    x_[omega] = initial.speed;
    if constexpr (feeds_back) appended_.begin(appended_states(x_), initial.speed);
  }
  void note_jump() noexcept SEXTANT_NONBLOCKING {
    ++revision_;
    ++jumps_;
  }
  void note_stator_resistance() noexcept SEXTANT_NONBLOCKING {
    flux_bound_.note_machine(machine_.largest_inductance(), machine_.stator_resistance());
  }
  void note_link_voltage() noexcept SEXTANT_NONBLOCKING {
    const T highest = std::max(u_dc(), inputs_.u_dc);  // of a link and its source, which charges it
    flux_bound_.note_voltage(highest + T(2) * drops_.threshold_voltage);
  }
  void settle_appended() noexcept SEXTANT_NONBLOCKING
    requires(feeds_back)
  {
    if (appended_.settle(appended_states(x_), x_[omega], inputs_)) note_jump();
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
  /// x: the whole state, or that of the machine. u_s: the stator voltage there [V]. has_threshold: whether
  /// the inverter may have one.
  template <bool has_threshold = false, class Vector>
  void derivative_at(const Vector& x, Vector& dx, SpaceVector<T> u_s) const noexcept SEXTANT_NONBLOCKING {
    const MachineEvaluation<T> e = machine_.evaluate(Layout::fluxes(x), u_s, x[omega]);
    const PlantInputs<T>& acting = inputs_at(x);
    Layout::put_fluxes(e.dpsi, dx);
    dx[omega] = shaft_.acceleration(e.tau_e, acting, x[omega]);
    dx[theta] = x[omega];
    if constexpr (Vector::RowsAtCompileTime > machine_size) {
      PlantQuantities<T> q = quantities_of(e, x, acting);
      q.u_s = u_s;
      q.i_dc = inverter_.dc_link_current(e.i_s);
      q.threshold_loss = has_threshold ? drops_.threshold_loss(e.i_s) : T(0);
      appended_.derivative(q, appended_states(x), appended_states(dx));
    }
  }
  /// Those of the machine at x and of the inputs that act there.
  template <class Vector>
  [[nodiscard]] PlantQuantities<T> quantities_of(const MachineEvaluation<T>& e, const Vector& x,
                                                 const PlantInputs<T>& acting) const noexcept
      SEXTANT_NONBLOCKING {
    PlantQuantities<T> q{static_cast<const MachineQuantities<T>&>(e)};
    const FluxPair<T> psi = Layout::fluxes(x);
    q.psi_s = psi.s;
    q.psi_r = psi.r;
    q.u_dc = acting.u_dc;
    q.tau_l = acting.tau_l;
    q.omega_m = x[omega];
    q.theta_m = x[theta];
    q.u_given = inputs_.u_dc;
    q.tau_given = inputs_.tau_l;
    q.inverter_loss = inputs_.inverter_loss;
    return q;
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
    const SpaceVector<T> psi_r = this->psi_r();
    Layout::put_fluxes({machine_.stator_flux(inverter_.admissible_current(i_s()), psi_r), psi_r}, x_);
  }

  void analytic_jacobian(const State& x, Jacobian& j) const noexcept SEXTANT_NONBLOCKING {
    const MachineSlopes<T> slopes = machine_.slopes(Layout::fluxes(x), x[omega]);
    const StatorVoltageMap<T>& map = inverter_.voltage_map();
    Eigen::Matrix<T, 2, 2> gain;  // of the back-EMF on the stator voltage
    gain << map.gain_alpha, map.gain_cross, map.gain_cross, map.gain_beta;
    j.setZero();
    j.template block<2, 5>(0, 0) = slopes.emf_share * gain * slopes.rotor + slopes.stator;
    j.template block<2, 5>(2, 0) = slopes.rotor;
    j(theta, omega) = T(1);
    if (inputs_.imposed_speed) return;
    j.template block<1, 5>(omega, 0) = shaft_.inverse_inertia() * slopes.torque;
    j(omega, omega) += shaft_.slope_by_speed(x[omega]);
  }

  Machine machine_;
  Appended appended_;
  MotorShaft<T> shaft_;
  FluxBound<T> flux_bound_{};
  ConductionDrops<T> drops_;
  Inverter<T> inverter_;
  PlantInputs<T> inputs_{};
  State x_{State::Zero()};
  std::uint64_t revision_{1};
  std::uint64_t jumps_{1};
};

}  // namespace sextant
