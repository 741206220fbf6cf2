#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "sextant/core/drive_io.hpp"
#include "sextant/core/minimum_pulse.hpp"
#include "sextant/plant/acted_segments.hpp"
#include "sextant/plant/appended_pair.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/driveline.hpp"
#include "sextant/plant/inverter_losses.hpp"
#include "sextant/plant/mean_duties.hpp"
#include "sextant/plant/plant_heating.hpp"
#include "sextant/plant/plant_integrator.hpp"
#include "sextant/plant/tied_segments.hpp"
#include "sextant/power_stage/dead_time.hpp"
#include "sextant/power_stage/faultable_drive_io.hpp"
#include "sextant/power_stage/friction_brake.hpp"
#include "sextant/power_stage/mechanical_load.hpp"
#include "sextant/power_stage/plant_fault.hpp"
#include "sextant/power_stage/pulse_filter.hpp"
#include "sextant/power_stage/segment_cursor.hpp"
#include "sextant/power_stage/segment_log.hpp"
#include "sextant/power_stage/sensor_model.hpp"

namespace sextant {

/// What of the inverter acts on the machine.
enum class InverterLaw : std::uint8_t {
  switched,  ///< what its legs do, edge by edge
  averaged   ///< their mean from read to read (`mean_duties`), while a pattern drives every leg
};

/// How the simulated power stage behaves.
struct SimulatedDriveIoParameters {
  std::int32_t period_ns{25'000};            ///< control period [ns]
  double u_dc{530.0};                        ///< voltage of the stiff DC link, or of a link's source [V]
  int actuation_delay_periods{0};            ///< 1: a pattern is applied one period after it was written [-]
  bool measures_angle{false};                ///< the measurement has the rotor's angle [-]
  bool measures_winding_temperature{false};  ///< the same of the winding's temperature, of a heated plant [-]
  int hold_periods{1};                       ///< periods for which a pattern is held without a new one [-]
  InverterLaw law{InverterLaw::switched};
  std::int32_t dead_time_ns{0};  ///< of the gate drivers, from one switch of a leg to the other one [ns]
  MinimumPulse::Parameters minimum_pulse{};  ///< of the gate drivers, before the dead time; none by default
  /// Time zero of the load's profiles, on the drive's clock; empty: the first read. [ns]
  std::optional<std::int64_t> load_origin_ns{0};
  SensorParameters sensors{};    ///< ideal by default
  PlantFaultParameters fault{};  ///< none by default; times count as the load's
  bool takes_faults{false};      ///< others may be injected while it runs [-]

  [[nodiscard]] const char* validate() const noexcept {
    if (period_ns <= 0) return "the control period must be above zero";
    if (!(std::isfinite(u_dc) && u_dc > 0.0)) return "the DC-link voltage must be above zero";
    if (actuation_delay_periods < 0 || actuation_delay_periods > 1) {
      return "the actuation delay must be 0 or 1 periods";
    }
    if (hold_periods < 1) return "a pattern must hold for at least one period";
    if (dead_time_ns < 0 || dead_time_ns >= period_ns - dead_time_ns) {
      return "the dead time must be from zero to below half of the control period";
    }
    const std::int32_t pulse_ns = minimum_pulse.duration_ns;
    if (pulse_ns < 0 || pulse_ns >= period_ns - pulse_ns) {
      return "the minimum pulse must be from zero to below half of the control period";
    }
    if (pulse_ns > 0 && pulse_ns < dead_time_ns) {
      return "the minimum pulse must be zero or at least the dead time: a shorter pulse turns no switch on";
    }
    if (const char* problem = sensors.validate()) return problem;
    if (!TemperatureSensor{sensors.temperature}.is_ideal() && !measures_winding_temperature)
      return "a temperature sensor with errors needs the winding's temperature to be measured";
    if (sensors.sampling_lead_ns > period_ns) return "the sampling lead must not exceed the control period";
    if (sensors.sampling_skew_ns > (period_ns - sensors.sampling_lead_ns) / 2)
      return "the sampling lead and twice the skew must not exceed the control period";
    return fault.validate();
  }
};

/// The law, dead time and minimum pulse alone, which belong to the inverter.
inline void describe_gate_drivers(Description& d, SimulatedDriveIoParameters& p) {
  auto& [shortest_ns, short_pulses] = p.minimum_pulse;
  d.choice("law", p.law, {{"switched", InverterLaw::switched}, {"averaged", InverterLaw::averaged}},
           "the machine gets each edge of the legs, or the mean of what they do over a control period, which "
           "is faster and has no ripple");
  d.time("dead_time_us", p.dead_time_ns,
         in_us(0, 5e4,
               "time for which both switches of a leg are off where it changes between low and high, while "
               "its diodes carry the current; the drive reads the commanded edges, and knows of it by "
               "drive.inverter.dead_time_us; 0: none"));
  d.time("minimum_pulse_us", shortest_ns,
         in_us(0, 5e4,
               "shortest time for which a leg stays high or low, before its dead time, as the gate drivers "
               "keep it: from the dead time to below half of the control period; short_pulses says what "
               "becomes of a shorter command, which the run counts; 0: none"));
  d.choice("short_pulses", short_pulses, short_pulses_choices,
           "a command shorter than minimum_pulse_us does not act, and each edge acts minimum_pulse_us late, "
           "as after a driver's input filter; or it acts for that long, and other edges at once");
}

/// The power stage as the drive sees it, with the plant integrated in this process.
///
/// read(t) first integrates the plant to t with the patterns written so far. Without a new pattern the gate
/// driver holds the last state for `hold_periods` and then turns the gates off, because a held vector moves
/// the torque far (docs/plant.md, gate patterns). `Measurement::applied` reports the applied pattern,
/// for which a pattern needs one segment to spare; without it, or after a gap of more than a second, the
/// measurement is not plausible. With a minimum pulse or a dead time the legs act otherwise (`PulseFilter`,
/// `DeadTime`): `applied` is what was commanded, as of a real gate driver. `Log` keeps the acted segments of
/// the last read.
///
/// The measurement is what the sensors read (`SensorModel`): by default the plant's true state.
///
/// Temperatures and resistances of a plant that is heated (`PlantHeating`) move at the beginning of a read,
/// so that they are the same over all of its segments.
///
/// With the averaged law the plant moves by the mean of what the legs do from read to read, with the signs
/// that the currents have at its beginning: without the ripple of a period. A pattern that turns a leg off
/// and an open cable act segment by segment.
///
/// Losses of the inverter (`InverterLosses`) are those of the segments that the log of a read has.
template <class Plant = DrivePlant<double>, class Log = NoSegmentLog<Plant>>
class SimulatedDriveIo final : public FaultableDriveIo {
 public:
  using Parameters = SimulatedDriveIoParameters;
  using PlantType = Plant;

  /// What is given by reference or pointer is not owned and must outlive this object; null: no heating, no
  /// losses.
  SimulatedDriveIo(const Parameters& parameters, Plant& plant, PlantIntegrator<Plant>& integrator,
                   const MechanicalLoad& load, PlantHeating<Plant>* heating = nullptr,
                   InverterLosses* losses = nullptr) noexcept
      : parameters_{parameters},
        plant_{plant},
        integrator_{integrator},
        load_{load},
        heating_{heating},
        losses_{losses},
        pulse_filter_{parameters.minimum_pulse},
        dead_time_{parameters.dead_time_ns},
        sensors_{parameters.sensors, parameters.fault, parameters.takes_faults},
        ties_{integrator.ties() && (parameters.dead_time_ns > 0 || plant.drops().threshold_voltage > 0)},
        has_stops_{!parameters.sensors.samples_at_once() || parameters.fault.acts_on_plant() ||
                   parameters.takes_faults} {}

  [[nodiscard]] Measurement<double> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING override {
    if (!started_) start(t_ns);
    log_.clear();
    may_tie_ = ties_;
    heat();
    if (has_stops_ && !failed_) [[unlikely]]
      prepare_stops(t_ns);
    const std::int64_t elapsed_ns = t_ns - plant_t_ns_;
    const GatePattern applied = acting_until(elapsed_ns);
    act(parameters_.fault.kind == PlantFaultKind::cables_swapped ? with_swapped_cables(applied) : applied);
    lose();
    // No room in `applied` for the segment with gates off, or a gap too long to integrate: the plant is not
    // at t_ns.
    const bool complete = applied.duration_ns() == elapsed_ns;
    Measurement<double> measured{
        .i_abc = plant_.i_abc(),
        .u_dc = link_voltage(),
        .omega_m = plant_.omega_m(),
        .applied = applied,
        .plausible = complete && healthy(),
        .theta_m = parameters_.measures_angle ? std::optional{wrapped(plant_.theta_m())} : std::nullopt,
        .winding_temperature =
            parameters_.measures_winding_temperature ? std::optional{temperatures().winding} : std::nullopt};
    if (!parameters_.sensors.samples_at_once()) [[unlikely]] {
      measured.i_abc = {sampled_current_[0], sampled_current_[1], sampled_current_[2]};
      measured.u_dc = sampled_u_dc_;
    }
    if (!sensors_.is_ideal()) [[unlikely]]
      sensors_.step(measured, plant_.theta_m(), t_ns, load_time(t_ns));
    return measured;
  }

  void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override {
    if (parameters_.actuation_delay_periods == 0) {
      active_ = pattern;
    } else {
      active_ = delayed_;
      delayed_ = pattern;
    }
  }

  void inject(const PlantFaultParameters& fault) noexcept SEXTANT_NONBLOCKING override {
    if (!parameters_.takes_faults) return;
    parameters_.fault = fault.since(load_time(plant_t_ns_));
    sensors_.set_fault(parameters_.fault);
    integrator_.reset();
  }

  /// Torque of a friction brake on the motor's shaft, not below zero, from now on. Not for a shaft whose
  /// speed is imposed, or with a load behind a driveline. [N·m]
  void set_brake(double torque) noexcept SEXTANT_NONBLOCKING { brake_.set(torque); }

  /// What that brake has turned into heat; empty where it has never been used. [J]
  [[nodiscard]] const std::optional<double>& brake_energy() const noexcept SEXTANT_NONBLOCKING {
    return brake_.energy();
  }

  [[nodiscard]] const Plant& plant() const noexcept SEXTANT_NONBLOCKING { return plant_; }

  /// The applied segments of the last read with the plant's states.
  [[nodiscard]] const Log& log() const noexcept SEXTANT_NONBLOCKING { return log_; }

  /// Load torque at the plant's present time, those of a vehicle and of its brake included: on the shaft, or
  /// on the load behind a `Driveline`, then referred to the motor's shaft. [N·m]
  [[nodiscard]] double tau_l() const noexcept SEXTANT_NONBLOCKING {
    const double given = load_.torque(load_time(plant_t_ns_));
    if constexpr (has_driveline)
      return part_of<Driveline<double>>(plant_.appended_system()).load_torque(driveline_states(), given);
    if (brake_.action().holds) return plant_.tau_e();
    return given + plant_.tau_road() + brake_.action().torque;
  }

  /// Speed of the load at the plant's present time, referred to the motor's shaft: behind a `Driveline` its
  /// own, else that of the motor, omega_m. [rad/s]
  [[nodiscard]] double load_speed(double omega_m) const noexcept SEXTANT_NONBLOCKING {
    if constexpr (has_driveline) return driveline_states()[Driveline<double>::load_speed];
    return omega_m;
  }

  /// Of the plant's machine over the last read; NaN where it is not heated. [°C]
  [[nodiscard]] ThermalNodes<double> temperatures() const noexcept SEXTANT_NONBLOCKING {
    if constexpr (can_heat) {
      if (heating_ != nullptr) return heating_->temperatures();
    }
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    return {unknown, unknown, unknown};
  }

  /// Losses of the inverter up to the plant's present time; null where it has none.
  [[nodiscard]] const InverterLosses* losses() const noexcept SEXTANT_NONBLOCKING { return losses_; }

  /// Commanded pulses shorter than the minimum pulse, so far; empty without one.
  [[nodiscard]] std::optional<std::int64_t> short_pulses() const noexcept SEXTANT_NONBLOCKING {
    return pulse_filter_.acts() ? std::optional{pulse_filter_.short_pulses()} : std::nullopt;
  }

  /// What the legs have done over the last read where the plant has moved by its mean; else empty.
  [[nodiscard]] std::span<const GateSegment> averaged() const noexcept SEXTANT_NONBLOCKING {
    return averaged_.segments();
  }

  /// False once an integration has failed or the flux exceeds what the DC link can produce; the plant then
  /// stays in its last state.
  [[nodiscard]] bool healthy() const noexcept SEXTANT_NONBLOCKING { return !failed_; }

 private:
  static constexpr std::int64_t never_ns = std::numeric_limits<std::int64_t>::max();
  /// The plant has an energy meter.
  static constexpr bool can_heat =
      has_part<EnergyMeter<typename Plant::Scalar>, typename Plant::AppendedType>;
  static constexpr bool has_driveline = has_part<Driveline<double>, typename Plant::AppendedType>;

  [[nodiscard]] Driveline<double>::Values driveline_states() const noexcept SEXTANT_NONBLOCKING
    requires(has_driveline)
  {
    return Plant::template states_of<Driveline<double>>(plant_.state());
  }

  /// Moves temperatures and resistances where that is due.
  void heat() noexcept {
    if constexpr (can_heat) {
      if (heating_ == nullptr || failed_) [[likely]]
        return;
      if (heating_->step(plant_)) integrator_.reset();
    }
  }

  /// What the inverter has lost over the segments of this read.
  void lose() noexcept {
    if constexpr (Log::wants_corners) {
      if (losses_ == nullptr || failed_) [[likely]]
        return;
      const auto currents = [this](std::size_t instant) noexcept {
        return inverse_clarke(plant_.stator_current(log_.instants()[instant]));
      };
      losses_->begin(link_voltage());
      for (const ActedSegment& segment : log_.segments())
        losses_->add_segment(segment.state, currents(segment.begin), currents(segment.end),
                             double(segment.duration_ns) * 1e-9);
      losses_->end();
    }
  }

  /// Into [−π, π]. [rad]
  static double wrapped(double angle) noexcept { return std::remainder(angle, 2.0 * std::numbers::pi); }

  void start(std::int64_t t_ns) noexcept {
    started_ = true;
    plant_t_ns_ = t_ns;
    load_origin_ns_ = parameters_.load_origin_ns.value_or(t_ns);
    u_dc_ = parameters_.u_dc;
    if (load_.imposes_speed()) plant_.set_speed(load_.speed(load_time(t_ns)));
    sensors_.begin(plant_.theta_m(), plant_.omega_m(), t_ns, parameters_.period_ns);
  }

  /// The drive's clock, as the profiles of the load count. [ns]
  [[nodiscard]] std::int64_t load_time(std::int64_t t_ns) const noexcept { return t_ns - load_origin_ns_; }

  /// The pattern in force, stretched to the time that has passed since the last read.
  [[nodiscard]] GatePattern acting_until(std::int64_t elapsed_ns) const noexcept {
    constexpr std::int64_t longest_ns = 1'000'000'000;
    const std::int64_t total = std::clamp<std::int64_t>(elapsed_ns, 0, longest_ns);
    const std::int64_t hold = std::int64_t{parameters_.hold_periods} * parameters_.period_ns;
    GatePattern applied;
    std::int64_t t = 0;
    for (const GateSegment& segment : active_.segments()) {
      const bool last = &segment == &active_.segments().back();
      const std::int64_t end = last ? std::max(hold, t + segment.duration_ns) : t + segment.duration_ns;
      const std::int64_t until = std::min(end, total);
      if (until > t) applied.append({segment.state, std::int32_t(until - t)});
      t = until;
    }
    if (t < total) applied.append({gates_off, std::int32_t(total - t)});
    return applied;
  }

  /// The pattern as the motor's phases get it behind exchanged cables.
  [[nodiscard]] GatePattern with_swapped_cables(const GatePattern& applied) const noexcept {
    const auto x = std::size_t(parameters_.fault.phase);
    GatePattern swapped;
    for (const GateSegment& segment : applied.segments()) {
      std::array<LegState, 3> legs{segment.state.a(), segment.state.b(), segment.state.c()};
      std::swap(legs[x], legs[(x + 1) % 3]);
      swapped.append({SwitchState{legs[0], legs[1], legs[2]}, segment.duration_ns});
    }
    return swapped;
  }

  /// At the beginning of a read at t_ns, for a fault and for currents that are sampled before.
  void prepare_stops(std::int64_t t_ns) noexcept {
    read_ns_ = t_ns;
    update_fault();
    sample(true);  // of a read that comes earlier than the lead
  }

  /// The currents whose samples are due at the plant's present time, or all, and with that of the last phase
  /// the link's voltage.
  void sample(bool all) noexcept {
    if (parameters_.sensors.samples_at_once()) return;
    const ThreePhase<> now = plant_.i_abc();
    const std::array<double, 3> i{now.a, now.b, now.c};
    for (int phase = 0; phase < 3; ++phase) {
      if (!all && plant_t_ns_ != sample_ns(phase)) continue;
      sampled_current_[std::size_t(phase)] = i[std::size_t(phase)];
      if (phase == 2) sampled_u_dc_ = link_voltage();
    }
  }
  /// Instant of that phase's sample for the read to come. [ns]
  [[nodiscard]] std::int64_t sample_ns(int phase) const noexcept {
    return read_ns_ - parameters_.sensors.lead_of(phase);
  }

  /// The fault at the plant's present time, and the time of the next stop.
  void update_fault() noexcept {
    const PlantFaultParameters& fault = parameters_.fault;
    const std::int64_t fault_ns = load_time(plant_t_ns_);
    const bool is_open = fault.kind_at(fault_ns) == PlantFaultKind::open_phase;
    plant_.open_phase(is_open ? fault.phase : Inverter<typename Plant::Scalar>::no_phase);
    u_dc_ = fault.link_voltage(parameters_.u_dc, fault_ns);
    contactor_ = fault.contactor(fault_ns);
    const std::int64_t corner_ns = fault.next_corner_ns(fault_ns);
    next_stop_ns_ = corner_ns == never_ns ? never_ns : plant_t_ns_ + (corner_ns - fault_ns);
    for (int phase = 0; phase < 3; ++phase) {
      if (sample_ns(phase) > plant_t_ns_) next_stop_ns_ = std::min(next_stop_ns_, sample_ns(phase));
    }
  }

  /// Integrates what the legs do under the commanded pattern.
  void act(const GatePattern& commanded) noexcept {
    if (parameters_.law == InverterLaw::averaged) [[unlikely]]
      return act_averaged(commanded);
    if (pulse_filter_.acts() || dead_time_.acts()) [[unlikely]] {
      const ActedSegments acted = acted_under(commanded);
      advance(acted.segments());
    } else {
      advance(commanded.segments());
    }
  }
  /// The same with their mean in the place of segments that a pattern drives.
  void act_averaged(const GatePattern& commanded) noexcept {
    const ActedSegments acted = acted_under(commanded);
    averaged_ = {};
    duties_.reset();
    if (!commanded.is_driven() || commanded.duration_ns() == 0 || !plant_.may_be_tied())
      return advance(acted.segments());
    averaged_ = acted;
    duties_ = mean_duties(acted.segments(), plant_.i_abc());
    const GateSegment whole{commanded.last_state(), std::int32_t(commanded.duration_ns())};
    advance({&whole, 1});
  }
  /// What the legs do.
  [[nodiscard]] ActedSegments acted_under(const GatePattern& commanded) noexcept {
    if (!pulse_filter_.acts()) return dead_time_.step(commanded.segments());
    const ActedSegments passed = pulse_filter_.step(commanded.segments());
    return dead_time_.step(passed.segments());
  }

  /// Between the corners of the load, so that a load step acts at its instant, and the stops.
  void advance(std::span<const GateSegment> acted) noexcept {
    SegmentCursor cursor{acted};
    while (!failed_ && !cursor.rest().empty()) {
      const std::int64_t load_ns = load_time(plant_t_ns_);
      const std::int64_t to_corner_ns = load_.next_corner_ns(load_ns) - load_ns;
      const std::int64_t to_stop_ns = next_stop_ns_ == never_ns ? never_ns : next_stop_ns_ - plant_t_ns_;
      const std::int64_t taken_ns = advance(cursor, std::min(to_corner_ns, to_stop_ns));
      plant_t_ns_ += taken_ns;
      if (taken_ns == to_corner_ns && !failed_) pass_corner();
      if (has_stops_ && !failed_) [[unlikely]] {
        update_fault();
        sample(false);
      }
    }
  }

  /// The load has a corner at the plant's present time: it may jump there.
  void pass_corner() noexcept {
    integrator_.reset();
    if (load_.imposes_speed()) jump_to(load_.speed(load_time(plant_t_ns_)));
  }

  /// Over the next segments as long as all are driven, else over the first of them, for most_ns at most.
  /// Returns how long that is. [ns]
  std::int64_t advance(SegmentCursor& cursor, std::int64_t most_ns) noexcept {
    const bool driven = plant_.is_driven_by(cursor.rest());
    if (!driven && may_tie_) [[unlikely]] {
      if (const std::int64_t taken_ns = advance_tied(cursor, most_ns); taken_ns > 0) return taken_ns;
    }
    const bool resumes = cursor.resumes();
    const auto segments = cursor.take(driven ? most_ns : std::min<std::int64_t>(most_ns, cursor.first_ns()));
    std::int64_t duration_ns = 0;
    for (const GateSegment& segment : segments) duration_ns += segment.duration_ns;
    set_inputs(segments[0].state, duration_ns);
    log_.begin(plant_);
    if constexpr (can_heat) {
      if (heating_ != nullptr) [[unlikely]]
        heating_->begin_piece(plant_);
    }
    std::array<typename Plant::State, Log::wants_corners ? GatePattern::capacity : 0> states;
    const std::span corners{states.data(), Log::wants_corners ? segments.size() : 0};
    failed_ = !integrator_.advance_through(plant_, segments, corners) || !plant_.is_reachable();
    if (!failed_) log_.end(plant_, segments, corners, resumes);
    if constexpr (can_heat) {
      if (heating_ != nullptr && !failed_) [[unlikely]]
        heating_->end_piece(plant_, duration_ns);
    }
    return duration_ns;
  }

  /// Over the next segments while every current keeps its sign (`TiedSegments`), for most_ns at most. Returns
  /// how long that is; 0 where one does not, and the plant where it was: then they go one by one, and so do
  /// the others of this read. [ns]
  std::int64_t advance_tied(SegmentCursor& cursor, std::int64_t most_ns) noexcept {
    const bool resumes = cursor.resumes();
    SegmentCursor ahead = cursor;
    const auto acted = ahead.take(most_ns);
    if (acted.size() < 2 || !plant_.may_be_tied()) return 0;
    std::int64_t duration_ns = 0;
    for (const GateSegment& segment : acted) duration_ns += segment.duration_ns;
    set_inputs(acted[0].state, duration_ns);
    const Plant before = plant_;
    const TiedSegments<Plant> tied{before, acted};
    plant_.set_switch_state(tied.segments()[0].state);
    const SpaceVector<> lost = plant_.threshold_voltage();
    std::array<typename Plant::State, GatePattern::capacity> states;
    const std::span corners{states.data(), acted.size()};
    const bool goes = integrator_.advance_tied(plant_, tied.segments(), corners) && plant_.is_reachable();
    if (!goes || !tied.hold(corners)) {
      plant_ = before;
      may_tie_ = false;
      return 0;
    }
    log_.begin(before);
    log_.end(plant_, acted, tied.segments(), lost, corners, resumes);
    plant_.set_switch_state(acted.back().state);
    if constexpr (can_heat) {
      if (heating_ != nullptr) {
        heating_->begin_piece(before);
        heating_->end_piece(plant_, duration_ns);
      }
    }
    cursor = ahead;
    return duration_ns;
  }

  /// For a piece in which the load is linear: its torque acts with its mean.
  void set_inputs(SwitchState state, std::int64_t duration_ns) noexcept {
    const std::int64_t begin_ns = load_time(plant_t_ns_);
    PlantInputs<double> inputs{state, acting_u_dc(begin_ns + duration_ns / 2),
                               load_.torque(begin_ns + duration_ns / 2), load_.imposes_speed(), 0.0};
    inputs.duties = duties_;
    if (brake_.acts()) [[unlikely]]
      brake(inputs);
    if (load_.imposes_speed()) {
      const double duration_s = double(duration_ns) * 1e-9;
      // To where the piece leads, not to what a jump at its end makes of it.
      const double end_speed = load_.speed(begin_ns) + load_.speed_slope(begin_ns) * duration_s;
      const double change = end_speed - plant_.omega_m();
      if (change != 0.0) inputs.speed_slope = change / duration_s;
    }
    if constexpr (moves_link_voltage<typename Plant::AppendedType>) {
      if (losses_ != nullptr) inputs.inverter_loss = losses_->drawn_power();
      inputs.contactor = contactor_;
    }
    plant_.set_inputs(inputs);
  }

  /// What the brake does over a piece.
  void brake(PlantInputs<double>& inputs) noexcept {
    const double speed = plant_.omega_m();
    const double other = plant_.tau_e() - inputs.tau_l - plant_.tau_road_at(speed);
    const FrictionBrake::Action action = brake_.step(plant_t_ns_, speed, other);
    inputs.tau_l += action.torque;
    inputs.imposed_speed = action.holds;
    if (action.holds && speed != 0.0) plant_.set_speed(0.0);
  }

  /// Link voltage over a piece whose middle is at `middle_ns` as the profiles of the load count. [V]
  [[nodiscard]] double acting_u_dc(std::int64_t middle_ns) const noexcept {
    return has_stops_ ? parameters_.fault.link_voltage(parameters_.u_dc, middle_ns) : parameters_.u_dc;
  }

  /// Of the link at the plant's present time. [V]
  [[nodiscard]] double link_voltage() const noexcept {
    PlantInputs<double> given{};
    given.u_dc = u_dc_;
    return plant_.acting(given).u_dc;
  }

  /// A step of the imposed speed acts at its instant; what is less than one is rounding.
  void jump_to(double speed) noexcept {
    constexpr double rounding_rad_s = 1e-6;
    if (std::abs(speed - plant_.omega_m()) > rounding_rad_s) plant_.set_speed(speed);
  }

  Parameters parameters_;
  Plant& plant_;
  PlantIntegrator<Plant>& integrator_;
  const MechanicalLoad& load_;
  PlantHeating<Plant>* heating_;  ///< null: none
  InverterLosses* losses_;        ///< null: none
  PulseFilter pulse_filter_;
  DeadTime dead_time_;
  SensorModel sensors_;
  FrictionBrake brake_{};
  bool ties_;       ///< legs have dead time or thresholds, over which the integrator can go
  bool may_tie_{};  ///< and no current has changed its sign since the read began
  bool has_stops_;  ///< the plant stops at other instants than those of gates and load
  Log log_{};
  ActedSegments averaged_{};                    ///< of the last read, by whose mean the plant has moved
  std::optional<ThreePhase<double>> duties_{};  ///< their mean [-]
  GatePattern active_{};
  GatePattern delayed_{};
  std::int64_t plant_t_ns_{0};
  std::int64_t load_origin_ns_{0};
  std::int64_t next_stop_ns_{never_ns};      ///< of the fault, or of sampling [ns]
  std::int64_t read_ns_{};                   ///< of the read for which currents and voltage are sampled [ns]
  std::array<double, 3> sampled_current_{};  ///< [A]
  double sampled_u_dc_{};                    ///< [V]
  double u_dc_{};                            ///< of the stiff link, or of the source, at the same time [V]
  Contactor contactor_{Contactor::automatic};  ///< of a link with pre-charge, at the same time
  bool started_{false};
  bool failed_{false};
};

}  // namespace sextant
