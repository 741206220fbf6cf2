#include "bench/closed_loops.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include "bench/closed_loop.hpp"
#include "bench/cpu_clock.hpp"
#include "sextant/config/load_config.hpp"
#include "support/source_directory.hpp"

namespace sextant::bench {
namespace {

constexpr double duration_s = 1.0;
constexpr double least_cpu_s = 0.5;  // the time of a run is the least of as many as fit
constexpr int most_repetitions = 5;

/// An imposed speed, or the free shaft from standstill; the torque reference goes to `torque` once the flux
/// is built up, to its negative and back.
struct OperatingPoint {
  std::optional<double> speed;  // [rad/s]
  double torque;                // that the machine can hold there [N·m]
};

constexpr std::array operating_points{OperatingPoint{0.0, 60.0},    OperatingPoint{50.0, 60.0},
                                      OperatingPoint{-50.0, 60.0},  OperatingPoint{150.0, 60.0},
                                      OperatingPoint{-150.0, 60.0}, OperatingPoint{300.0, 30.0},
                                      OperatingPoint{-300.0, 30.0}, OperatingPoint{{}, 100.0}};

struct NamedIntegrator {
  const char* name;
  IntegratorKind kind;
};
constexpr std::array integrators{
    NamedIntegrator{"fixed", IntegratorKind::fixed}, NamedIntegrator{"exact", IntegratorKind::exact},
    NamedIntegrator{"erk", IntegratorKind::erk}, NamedIntegrator{"cvode", IntegratorKind::cvode}};

Scenario scenario_at(const OperatingPoint& point) {
  Scenario scenario;
  scenario.duration_ns = std::int64_t(duration_s * 1e9);
  scenario.torque_reference = {.shape = ProfileShape::steps,
                               .points = {{0.0, 0.0},
                                          {0.3 * duration_s, point.torque},
                                          {0.6 * duration_s, -point.torque},
                                          {0.8 * duration_s, point.torque}}};
  if (point.speed) scenario.load.imposed_speed = ProfileParameters{.value = *point.speed};
  scenario.metrics.from_ns = scenario.duration_ns / 2;
  return scenario;
}

/// CVODE that restarts at each switching, so tight that it stands for the equations.
SimulatedPowerStageParameters reference_of(SimulatedPowerStageParameters parameters) {
  parameters.integrator = IntegratorKind::cvode;
  parameters.cvode = cvode_at(1e-12);
  parameters.cvode.at_switching = AtSwitching::stop;
  return parameters;
}

double peak(const ClosedLoop::Torque& torque) {
  double largest = 0.0;
  for (const double tau : torque) largest = std::max(largest, std::abs(tau));
  return largest;
}

double largest_difference(const ClosedLoop::Torque& a, const ClosedLoop::Torque& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, std::abs(a[k] - b[k]));
  return largest;
}

/// Least CPU time of a whole run. [s]
double cpu_time(const ClosedLoop& loop, IntegratorKind kind) {
  double least_s = std::numeric_limits<double>::infinity();
  double spent_s = 0.0;
  for (int n = 0; n < most_repetitions && spent_s < least_cpu_s; ++n) {
    const double begin_ns = process_cpu_ns();
    if (!loop.run(kind).plant_healthy) throw std::runtime_error{"an integration failed"};
    const double cpu_s = 1e-9 * (process_cpu_ns() - begin_ns);
    least_s = std::min(least_s, cpu_s);
    spent_s += cpu_s;
  }
  return least_s;
}

nlohmann::json measure(const ClosedLoop& loop, const SimulatedPowerStageParameters& shipped) {
  const ClosedLoop::Patterns patterns = loop.record();
  const ClosedLoop::Torque reference = loop.replay(patterns, reference_of(shipped));
  nlohmann::json found{{"peak_torque_nm", peak(reference)}};
  double segments = 0.0;
  for (const GatePattern& pattern : patterns) segments += double(pattern.segments().size());
  found["segments_a_period"] = segments / double(patterns.size());
  for (const NamedIntegrator& integrator : integrators) {
    SimulatedPowerStageParameters parameters = shipped;
    parameters.integrator = integrator.kind;
    const double error_nm = largest_difference(loop.replay(patterns, parameters), reference);
    found["integrators"][integrator.name] = {
        {"error_of_peak", error_nm / peak(reference)},
        {"cpu_s_per_simulated_s", cpu_time(loop, integrator.kind) / duration_s}};
  }
  return found;
}

}  // namespace

CvodeParameters cvode_at(double tolerance, CvodeMethod method) {
  CvodeParameters p{};
  p.method = method;
  p.relative_tolerance = tolerance;
  p.flux_tolerance = p.speed_tolerance = p.angle_tolerance = 1e-2 * tolerance;
  return p;
}

nlohmann::json closed_loops() {
  nlohmann::json result;
  for (const std::string controller : {"dtc", "foc"}) {
    const DriveConfig config = load_ecu_config(std::string{SEXTANT_SOURCE_DIR} + "/configs/ecu.toml",
                                               {"control.controller=" + controller})
                                   .drive;
    for (const OperatingPoint& point : operating_points) {
      nlohmann::json found = measure(ClosedLoop{config, scenario_at(point)}, config.plant);
      found["controller"] = controller;
      found["speed_rad_s"] = point.speed ? nlohmann::json(*point.speed) : nlohmann::json{};
      result.push_back(found);
    }
  }
  return result;
}

}  // namespace sextant::bench
