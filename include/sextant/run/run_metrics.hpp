#pragma once

#include <optional>
#include <vector>

#include "sextant/run/cycle_following.hpp"
#include "sextant/run/metrics.hpp"
#include "sextant/run/scenario.hpp"
#include "sextant/run/torque_answer.hpp"

namespace sextant {

/// The metrics of a run: those of its own window, and of each window that has limits of its own; and whether
/// it made the torque and followed the cycle that it was given.
class RunMetrics {
 public:
  /// Throws std::runtime_error where a window is none.
  explicit RunMetrics(const Scenario& scenario) : run_{scenario.metrics} {
    windows_.reserve(scenario.windows.size());
    for (const WindowExpectation& w : scenario.windows) {
      MetricsParameters window = scenario.metrics;
      window.from_ns = w.window.from_ns;
      window.to_ns = w.window.to_ns;
      windows_.emplace_back(window);
    }
    if (!scenario.cycle) return;
    following_.emplace(scenario.cycle->speed);
    wheel_radius_ = scenario.cycle->driver.wheel_radius;
  }

  void add_segment(const MetricsSample& before, const MetricsSample& after) noexcept {
    run_.add_segment(before, after);
    for (MetricsAccumulator& w : windows_) w.add_segment(before, after);
    const double duration_ns = double(after.t_ns - before.t_ns) + (after.fraction_ns - before.fraction_ns);
    if (answer_) answer_->add_segment(before.torque, after.torque, duration_ns);
    if (following_) following_->add(after.t_ns, wheel_radius_ * after.omega_m);
  }
  void commutate(std::int64_t t_ns, SwitchState state) noexcept {
    run_.commutate(t_ns, state);
    for (MetricsAccumulator& w : windows_) w.commutate(t_ns, state);
  }
  void pulse(std::int64_t t_ns, std::int64_t count = 1) noexcept {
    run_.pulse(t_ns, count);
    for (MetricsAccumulator& w : windows_) w.pulse(t_ns, count);
  }
  void note_temperatures(std::int64_t t_ns, const ThermalNodes<double>& temperatures) noexcept {
    run_.note_temperatures(t_ns, temperatures);
    for (MetricsAccumulator& w : windows_) w.note_temperatures(t_ns, temperatures);
  }
  void note_inverter(std::int64_t t_ns, double junction, double device_case) noexcept {
    run_.note_inverter(t_ns, junction, device_case);
    for (MetricsAccumulator& w : windows_) w.note_inverter(t_ns, junction, device_case);
  }
  void begin_period(const Telemetry<double>& telemetry, double command) noexcept {
    run_.begin_period(telemetry, command);
    for (MetricsAccumulator& w : windows_) w.begin_period(telemetry, command);
    if (answer_) answer_->begin_period(telemetry, command);
  }
  void has_control_period(std::int64_t period_ns) {
    run_.has_control_period(period_ns);
    for (MetricsAccumulator& w : windows_) w.has_control_period(period_ns);
    answer_.emplace();
  }
  void has_no_pulses() noexcept {
    run_.has_no_pulses();
    for (MetricsAccumulator& w : windows_) w.has_no_pulses();
  }

  /// The torque that was asked and not made; empty where it was, and of a run without control periods.
  [[nodiscard]] std::optional<MissingTorque> missing_torque() const noexcept {
    return answer_ ? answer_->missing() : std::nullopt;
  }

  /// How the vehicle left its cycle; empty where it followed, and without a driver.
  [[nodiscard]] std::optional<CycleDeparture> cycle_departure() const noexcept {
    return following_ ? following_->departure() : std::nullopt;
  }

  /// Those of the run's own window.
  [[nodiscard]] MetricList metrics() const noexcept { return run_.metrics(); }

  /// Those of the other windows, in the scenario's order. What only the run as a whole has is taken from it.
  [[nodiscard]] std::vector<MetricList> window_metrics(const MetricList& run) const {
    std::vector<MetricList> all;
    for (const MetricsAccumulator& w : windows_) {
      all.push_back(w.metrics());
      for (const Metric m : {Metric::dwell_limited, Metric::short_pulses, Metric::energy_brake,
                             Metric::simulated, Metric::wall, Metric::realtime_factor})
        all.back()[m] = run[m];
    }
    return all;
  }

 private:
  MetricsAccumulator run_;
  std::vector<MetricsAccumulator> windows_{};
  std::optional<TorqueAnswer> answer_{};       // of a sampled run
  std::optional<CycleFollowing> following_{};  // of a run with a driver
  double wheel_radius_{};                      // [m]
};

}  // namespace sextant
