#include "sextant/config/scenario_config.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "drive_sections.hpp"
#include "number_text.hpp"
#include "plant_effects.hpp"

namespace sextant {
namespace {

/// An instant of the run, or the last one that it may have, where a time may be left out. [ns]
TimeQuantity instant(const char* meaning) {
  return in_s(0, 1e6, meaning);
}
void window_end(Section& s, const char* key, std::int64_t& to_ns, const char* meaning) {
  const TimeQuantity end = instant(meaning);
  s.number(key, NumberMember::unless_last(to_ns, end.unit_ns), end.quantity);
}

void describe(Section s, MetricsParameters& p, const Drive<>::Parameters& drive) {
  s.time("window_from_s", p.from_ns, instant("beginning of the window of steady metrics"));
  window_end(s, "window_to_s", p.to_ns, "end of that window; not set: the end of the run");
  const TimeQuantity step = instant("instant of the torque step whose response time is taken");
  s.number("step_s", {p.step_ns, step.unit_ns}, step.quantity);
  s.defaulted_by(
      "torque_tolerance_nm", p.torque_tolerance,
      [&p, &drive] {
        p.torque_tolerance = std::min(drive.command.torque_limit, drive.motor.capability.torque) / 75;
      },
      {"N·m", 1e-6, 1e5,
       "deviation of the mean torque over 20 ms that torque_silent_ms allows, or 5 %, the larger one"});
  s.check(p);
}

/// One bound of one metric; the list has an entry for each metric that has a bound, in catalogue order.
void bound(Section& s, std::vector<Expectation>& list, Metric metric, const char* key,
           std::optional<double> Expectation::* member) {
  constexpr Range<double> any{-1e12, 1e12};
  const std::string name = info(metric).name;
  const auto find = [&list, name] {
    return std::find_if(list.begin(), list.end(), [&name](const Expectation& e) { return e.metric == name; });
  };
  const auto get = [&list, find, member]() -> std::optional<double> {
    const auto entry = find();
    return entry == list.end() ? std::nullopt : (*entry).*member;
  };
  const auto set = [&list, find, member, name, metric](const Value& x) {
    auto entry = find();
    if (entry == list.end()) {
      const auto next = std::find_if(list.begin(), list.end(), [metric](const Expectation& e) {
        return find_metric(e.metric).value_or(metric) > metric;
      });
      entry = list.insert(next, Expectation{name, {}, {}});
    }
    (*entry).*member = std::get<double>(x);
  };
  s.add(key, info(metric).unit, info(metric).meaning, NumberKind{any}, {get, set});
}

void describe(Section s, std::vector<Expectation>& list) {
  for (std::size_t k = 0; k < metric_count; ++k) {
    const auto metric = static_cast<Metric>(k);
    Section entry = s.section(info(metric).name);
    bound(entry, list, metric, "min", &Expectation::min);
    bound(entry, list, metric, "max", &Expectation::max);
  }
  s.check([&list]() -> std::string {
    for (const Expectation& e : list) {
      if (std::string problem = e.validate(); !problem.empty()) return problem;
    }
    return {};
  });
}

void describe(Section s, WindowExpectation& w) {
  s.time("from_s", w.window.from_ns, instant("beginning of a window with limits of its own"));
  window_end(s, "to_s", w.window.to_ns, "end of that window; not set: the end of the run");
  describe(s, w.limits);
  s.check([&w]() -> std::string {
    if (w.window.to_ns <= w.window.from_ns) return "the window must end after it begins";
    return w.limits.empty() ? "the window has no limit" : "";
  });
}

/// The trip that is expected, if any.
void describe_fault(Section s, ScenarioConfig& c) {
  std::vector<Choice<Fault>> faults;
  faults.reserve(fault_count);
  for (int k = 0; k < fault_count; ++k) faults.push_back({to_string(Fault(k)), Fault(k)});
  s.choice("fault", c.expected_fault, faults,
           "the fault that has to trip the drive first; none: a trip is no success", "none");
  s.time("fault_from_s", c.expected_fault_window.from_ns, instant("earliest time of that fault"));
  window_end(s, "fault_to_s", c.expected_fault_window.to_ns,
             "latest time of that fault; not set: the end of the run");
  s.check([&c]() -> std::string {
    const TimeWindow& w = c.expected_fault_window;
    const bool is_limited = w.from_ns != 0 || w.to_ns != TimeWindow{}.to_ns;
    if (is_limited && !c.expected_fault) return "fault_from_s and fault_to_s need a fault";
    return w.to_ns < w.from_ns ? "fault_to_s must not be before fault_from_s" : "";
  });
}

/// Empty when the command supervision accepts the torque reference of the run, else a sentence. Only sampled
/// runs have command supervision; a driver has a limit of its own.
std::string validate_torque(const ScenarioConfig& c) {
  if (c.mode != ScenarioMode::sampled || c.expected_fault || c.cycle.drives_vehicle()) return {};
  if (!c.scenario.torque_reference.validate().empty()) return {};
  const double most = largest_magnitude(c.scenario.torque_reference, c.scenario.duration_ns);
  const double limit = c.drive.drive.command.torque_limit;
  if (!(most > limit)) return {};
  return "the torque reaches " + number_text(most) + " N·m, beyond command.torque_limit_nm, " +
         number_text(limit) + " N·m: the drive would block it and trip; lower it or raise the limit";
}

/// Empty when the imposed speed of the run does not trip the drive, or a trip is expected; else a sentence.
std::string validate_speed(const ScenarioConfig& c) {
  if (c.expected_fault || !c.scenario.load.imposed_speed) return {};
  return validate_imposed_speed(c.drive, *c.scenario.load.imposed_speed, c.scenario.duration_ns);
}

/// What holds between the parts of a run.
std::string validate(const Scenario& scenario) {
  const auto demands_response = [](const Expectation& e) {
    return find_metric(e.metric) == Metric::response_time;
  };
  for (const WindowExpectation& w : scenario.windows) {
    if (w.window.from_ns >= scenario.duration_ns) return "a window of [[expect.window]] begins after the run";
  }
  const MetricsParameters& m = scenario.metrics;
  if (m.from_ns >= scenario.duration_ns) return "the window of the metrics begins after the run has ended";
  if (m.step_ns && *m.step_ns >= scenario.duration_ns)
    return "the step of the metrics comes after the run has ended";
  if (m.step_ns && *m.step_ns > 0) {
    // At 0 a step comes from nothing.
    if (!scenario.torque_reference.validate().empty()) return {};
    const Profile reference{scenario.torque_reference};
    const std::vector<std::int64_t>& jumps = reference.jumps_ns();
    if (scenario.cycle || std::find(jumps.begin(), jumps.end(), *m.step_ns) == jumps.end())
      return "metrics.step_s must be 0 or an instant at which the torque reference jumps";
  }
  const auto one_demands_response = [&demands_response](const std::vector<Expectation>& list) {
    return std::any_of(list.begin(), list.end(), demands_response);
  };
  const bool in_a_window =
      std::any_of(scenario.windows.begin(), scenario.windows.end(),
                  [&](const WindowExpectation& w) { return one_demands_response(w.limits); });
  if (!m.step_ns && (in_a_window || one_demands_response(scenario.expectations))) {
    return "a response time is expected, but metrics.step_s is not set";
  }
  return {};
}

/// What an event-exact run cannot do without, or not with.
std::string validate_event_exact(const ScenarioConfig& c) {
  if (c.mode != ScenarioMode::event_exact) return {};
  if (c.drive.controller != DirectTorqueController<>::name)
    return "an event-exact run has comparators in continuous time, control.controller must be \"dtc\"";
  if (c.drive.control.actuation_delay_periods != 0)
    return "an event-exact run has no control period, drive.actuation_delay_periods must be 0";
  if (c.drive.control.flux_estimator != FluxEstimatorKind::voltage_model)
    return "an event-exact run integrates the paper's voltage model, control.flux_estimator must be "
           "\"voltage_model\"";
  const DirectTorqueController<>::Parameters& dtc = c.drive.direct_torque();
  if (dtc.flux_priority || dtc.torque_trim.time_constant != 0)
    return "an event-exact run has the table and the comparators of the paper alone, "
           "control.dtc.flux_priority must be false and control.dtc.torque_trim_ms 0";
  if (c.drive.drive.magnetise_first)
    return "an event-exact run has no drive states, set drive.magnetise_first = false and give "
           "event_exact.initial_flux_wb instead";
  if (c.drive.drive.motor.optimal_flux.optimum != FluxOptimum::constant)
    return "an event-exact run has no drive around its controller, drive.flux_optimum must be \"constant\"";
  if (std::string problem = excluded_effect(c.drive.plant, &PlantEffect::event_exact); !problem.empty())
    return problem;
  const IntegratorKind integrator = c.drive.plant.integrator;
  if (integrator != IntegratorKind::cvode && integrator != IntegratorKind::fixed)
    return "an event-exact run is moved by cvode or fixed, plant.integrator must be one of them";
  return {};
}

/// What holds between the control period of a sampled run and its other parts.
std::string validate_sampling(const ScenarioConfig& c) {
  if (c.mode != ScenarioMode::sampled) return {};
  if (c.scenario.duration_ns < c.drive.drive.period_ns)
    return "the run must last at least one control period";
  const double interval_ns = c.scenario.trace.interval_us * 1e3;
  const double periods = interval_ns / static_cast<double>(c.drive.drive.period_ns);
  const double ratio = std::max(periods, 1 / periods);
  if (std::abs(ratio - std::round(ratio)) > 1e-9 * ratio) {
    return "trace.interval_us must be a whole number of control periods or a whole part of one";
  }
  if (std::abs(interval_ns - std::round(interval_ns)) > 1e-6)
    return "trace.interval_us must be a whole number of nanoseconds";
  return {};
}

/// What a trace may hold, whichever control method is chosen.
std::vector<std::string> all_signals(const ControlMethods& methods) {
  std::vector<std::string> names = trace_signals();
  for (const auto& method : methods) {
    for (const ControlChannel& c : method->channels()) names.push_back(std::string{"control/"} + c.name);
  }
  return names;
}

std::string signals_text() {
  std::string groups;
  for (const std::string& group : trace_groups()) groups += (groups.empty() ? "\"" : ", \"") + group + '"';
  return "groups (" + groups + ") and signals (\"plant/i_dc_a\")";
}

/// A trace holds the channels of its own controller alone.
std::string validate_signals(const ScenarioConfig& c) {
  const std::vector<std::string> there = trace_signals(c.drive.method().channels());
  for (const std::string& name : c.scenario.trace.signals) {
    if (std::find(there.begin(), there.end(), name) == there.end())
      return "signal \"" + name + "\" belongs to another controller than control.controller, \"" +
             c.drive.controller + "\"";
  }
  return {};
}

/// A cycle determines torque and load; no other key may.
std::string validate_alone(const ScenarioConfig& c) {
  if (!c.cycle.is_given()) return {};
  if (is_given(c.torque_nm)) return "give a cycle or profile.torque_nm, not both";
  const LoadConfig& load = c.drive.load;
  const bool is_loaded =
      load.kind != LoadConfig::Kind::torque || is_given(load.torque) || is_given(load.imposed_speed);
  return is_loaded ? "give a cycle or load, not both" : "";
}

/// A cycle without a vehicle imposes the speed of the motor, and a vehicle has its own gear.
std::string validate_shaft_of_cycle(const ScenarioConfig& c) {
  if (!c.cycle.is_given()) return {};
  if (!c.cycle.drives_vehicle()) return validate_free_shaft(c.drive.plant, true);
  if (c.cycle.vehicle.brake_torque > 0 && c.drive.plant.driveline.acts())
    return "vehicle.brake_torque_nm acts on the motor's shaft: it must be 0 with plant.driveline";
  if (c.cycle.vehicle.brake_torque > 0 && c.mode == ScenarioMode::event_exact)
    return "an event-exact run has no friction brake: vehicle.brake_torque_nm must be 0";
  if (c.drive.plant.driveline.gear_ratio == 1) return {};
  return "the gear of the vehicle is vehicle.gear_ratio: plant.driveline.gear_ratio must be 1";
}

/// The command supervision blocks a torque beyond its limit.
std::string validate_driver(const ScenarioConfig& c) {
  if (!c.cycle.drives_vehicle()) return {};
  const double speed = c.cycle.vehicle.motor_radius() * c.drive.plant.plant.initial.speed;
  if (!c.cycle.speed.points.empty() &&
      !(std::abs(c.cycle.speed.points.front().value - speed) <= 0.01 * std::abs(speed))) {
    return speed == 0.0 ? "the cycle must begin at rest, where the vehicle is"
                        : "the cycle must begin within 1 % of the vehicle's speed, " + number_text(speed) +
                              " m/s by plant.initial_speed_rad_s";
  }
  const bool beyond = c.drive.drive.command.torque_limit < c.cycle.driver.torque_limit;
  const bool has_supervision = c.mode == ScenarioMode::sampled;
  return has_supervision && beyond ? "torque_limit_nm is above command.torque_limit_nm" : "";
}

/// The torque that a grade over time asks of one motor; linear between the points, as the grade is.
ProfileParameters grade_load(const VehicleParameters& vehicle, ProfileParameters grade) {
  for (ProfilePoint& point : grade.points) point.value = grade_torque(vehicle, point.value);
  return grade;
}

/// Puts the vehicle on the shaft and its driver into the scenario.
void prescribe_vehicle(ScenarioConfig& c) {
  DrivePlantParameters<>& plant = c.drive.plant.plant;
  Driver::Parameters& driver = c.cycle.driver;
  plant.road_load = road_load(c.cycle.vehicle);
  if (c.cycle.grade) c.scenario.load.load_torque = grade_load(c.cycle.vehicle, *c.cycle.grade);
  driver.mass = accelerated_mass(c.cycle.vehicle, plant.machine.inertia + c.drive.plant.driveline.inertia);
  driver.wheel_radius = c.cycle.vehicle.motor_radius();
  driver.motors = c.cycle.vehicle.motors;
  driver.brake_torque = c.cycle.vehicle.brake_torque / c.cycle.vehicle.gear_ratio;
  c.scenario.cycle = DrivenCycle{c.cycle.speed, driver};
}

/// Torque reference and load of the run.
void prescribe(ScenarioConfig& c) {
  Scenario& scenario = c.scenario;
  scenario.torque_reference = c.torque_nm;
  scenario.load = c.drive.load.parameters();
  scenario.expected_fault.reset();
  if (c.expected_fault)
    scenario.expected_fault = FaultExpectation{*c.expected_fault, c.expected_fault_window};
  if (!c.cycle.is_given() || !c.cycle.validate().empty()) return;
  if (c.cycle.drives_vehicle()) return prescribe_vehicle(c);
  PassiveEvLoad::Profiles profiles = PassiveEvLoad{c.cycle.passive_ev}.along(c.cycle.speed);
  scenario.torque_reference = std::move(profiles.torque);
  scenario.load = {{}, std::move(profiles.wheel_speed)};
}

}  // namespace

EventExactRunner::Parameters ScenarioConfig::event_exact_runner() const {
  return {.plant = drive.plant.plant,
          .control = drive.direct_torque(),
          .protection = drive.drive.protection,
          .event_exact = event_exact,
          .integrator = drive.plant.integrator,
          .cvode = drive.plant.cvode,
          .u_dc = drive.plant.io.u_dc};
}

void describe(Section root, ScenarioConfig& c) {
  Scenario& scenario = c.scenario;
  root.text("name", scenario.name, "short name of the run", false);
  root.required();
  root.text("description", scenario.description, "what the run shows", true);
  root.time("duration_s", scenario.duration_ns, in_s(1e-6, 1e6, "length of the run"));
  root.required();
  root.choice("mode", c.mode,
              {{"sampled", ScenarioMode::sampled}, {"event_exact", ScenarioMode::event_exact}},
              "controller once per period, or comparators in continuous time");
  describe_parameters(root.section("event_exact"), c.event_exact);
  describe(root, c.drive);
  describe(root.section("profile").section("torque_nm"), c.torque_nm, "N·m", {-1e5, 1e5});
  describe(root, c.cycle, [&c] {
    return std::min(c.drive.drive.command.torque_limit, c.drive.drive.motor.capability.torque);
  });
  root.section("cycle").check([&c] { return validate_alone(c); });
  root.section("cycle").check([&c] { return validate_shaft_of_cycle(c); });
  root.section("driver").check([&c] { return validate_driver(c); });
  root.derive([&c] { prescribe(c); });
  describe(root.section("metrics"), scenario.metrics, c.drive.drive);
  Section trace = root.section("trace");
  trace.number(
      "interval_us", scenario.trace.interval_us,
      {"us", 1, 1e9, "one row of the trace: a whole number of control periods or a whole part of one"});
  trace.names("signals", scenario.trace.signals, all_signals(c.drive.methods), signals_text(),
              "what the trace holds beside the time");
  trace.check(scenario.trace);
  trace.check([&c] { return validate_signals(c); });
  Section expect = root.section("expect");
  describe_fault(expect, c);
  describe(expect, scenario.expectations);
  expect.list<WindowExpectation>("window", scenario.windows,
                                 [](Section s, WindowExpectation& w) { describe(std::move(s), w); });
  check_simulated_plant(root, c.drive, [&c] { return !c.expected_fault; });
  const auto check_given_by = [&](Section key, std::string (*problem)(const ScenarioConfig&)) {
    key.check([&c, problem] { return c.cycle.is_given() ? std::string{} : problem(c); });
    root.section("cycle").check([&c, problem] { return c.cycle.is_given() ? problem(c) : std::string{}; });
  };
  check_given_by(root.section("load").section("speed_rad_s"), validate_speed);
  check_given_by(root.section("profile").section("torque_nm"), validate_torque);
  root.check([&c] { return validate(c.scenario); });
  root.section("mode").check([&c] { return validate_event_exact(c); });
  root.check([&c] { return validate_sampling(c); });
}

}  // namespace sextant
