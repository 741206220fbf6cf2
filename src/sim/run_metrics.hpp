#pragma once

#include <vector>

#include "sextant/sim/metrics.hpp"
#include "sextant/sim/scenario.hpp"

namespace sextant {

/// The metrics of a run: those of its own window, and of each window that has limits of its own.
class RunMetrics {
 public:
  /// Throws std::runtime_error where a window is none.
  explicit RunMetrics(const Scenario& scenario) : run_{scenario.metrics} {
    windows_.reserve(scenario.windows.size());
    for (const WindowExpectation& w : scenario.windows) {
      windows_.emplace_back(MetricsParameters{
          .from_ns = w.window.from_ns, .to_ns = w.window.to_ns, .step_ns = scenario.metrics.step_ns});
    }
  }

  void add_segment(const MetricsSample& before, const MetricsSample& after) noexcept {
    run_.add_segment(before, after);
    for (MetricsAccumulator& w : windows_) w.add_segment(before, after);
  }
  void commutate(std::int64_t t_ns, SwitchState state) noexcept {
    run_.commutate(t_ns, state);
    for (MetricsAccumulator& w : windows_) w.commutate(t_ns, state);
  }
  void pulse(std::int64_t t_ns, std::int64_t count = 1) noexcept {
    run_.pulse(t_ns, count);
    for (MetricsAccumulator& w : windows_) w.pulse(t_ns, count);
  }
  void begin_period(const Telemetry<double>& telemetry, double command) noexcept {
    run_.begin_period(telemetry, command);
    for (MetricsAccumulator& w : windows_) w.begin_period(telemetry, command);
  }
  void has_control_period(std::int64_t period_ns) {
    run_.has_control_period(period_ns);
    for (MetricsAccumulator& w : windows_) w.has_control_period(period_ns);
  }
  void has_no_pulses() noexcept {
    run_.has_no_pulses();
    for (MetricsAccumulator& w : windows_) w.has_no_pulses();
  }

  /// Those of the run's own window.
  [[nodiscard]] MetricList metrics() const noexcept { return run_.metrics(); }

  /// Those of the other windows, in the scenario's order. What only the run as a whole has is taken from it.
  [[nodiscard]] std::vector<MetricList> window_metrics(const MetricList& run) const {
    std::vector<MetricList> all;
    for (const MetricsAccumulator& w : windows_) {
      all.push_back(w.metrics());
      for (const Metric m : {Metric::dwell_limited, Metric::simulated, Metric::wall, Metric::realtime_factor})
        all.back()[m] = run[m];
    }
    return all;
  }

 private:
  MetricsAccumulator run_;
  std::vector<MetricsAccumulator> windows_{};
};

}  // namespace sextant
