#include "sextant/event_exact/event_exact_runner.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "event_exact_reference.hpp"
#include "event_exact_trace.hpp"
#include "sextant/drive/fault_memory.hpp"
#include "sextant/event_exact/cvode_event_engine.hpp"
#include "sextant/event_exact/event_exact_simulation.hpp"
#include "sextant/event_exact/fixed_step_event_engine.hpp"
#include "sextant/run/plant_look.hpp"
#include "sextant/run/progress_ticker.hpp"
#include "sextant/run/run_metrics.hpp"

namespace sextant {
namespace {

/// One event-exact run: the surroundings of the system from stretch to stretch, and what is observed of it.
template <class Engine>
class EventExactRun {
 public:
  EventExactRun(const EventExactRunner::Parameters& parameters, const Scenario& scenario, Engine& engine,
                TraceRecorder* trace)
      : parameters_{parameters},
        scenario_{scenario},
        reference_{scenario},
        load_{scenario.load},
        protection_{parameters.protection},
        metrics_{scenario},
        system_{parameters.plant, parameters.control, parameters.event_exact.sector_mask},
        simulation_{parameters.event_exact, system_, engine} {
    if (trace != nullptr) trace_.emplace(*trace, scenario.trace.interval_us);
  }

  [[nodiscard]] MilResult run(const MilRunner::Progress& progress) {
    constexpr std::uint32_t stretches_a_clock_reading = 8;
    ProgressTicker ticker{progress, stretches_a_clock_reading};
    start();
    while (t_ns_ < scenario_.duration_ns && !result_.faults.any()) {
      if (!run_stretch()) {
        result_.plant_healthy = false;
        result_.events_ended = simulation_.events_ended();
        break;
      }
      result_.stopped = !ticker.tick(double(t_ns_) / double(scenario_.duration_ns));
      if (result_.stopped) break;
    }
    return finish();
  }

 private:
  static constexpr std::int64_t longest_stretch_ns = 1'000'000;

  void start() {
    if (parameters_.event_exact.initial_flux > 0) system_.magnetise(parameters_.event_exact.initial_flux);
    if (load_.imposes_speed()) system_.set_speed(load_.speed(0));
  }

  /// Between the corners of the profiles, within which everything runs in straight lines.
  [[nodiscard]] EventExactStretch next_stretch() {
    const EventExactReference::Line reference = reference_.at(t_ns_, system_.plant().omega_m());
    const std::int64_t end_ns = std::min({scenario_.duration_ns, t_ns_ + longest_stretch_ns, reference.end_ns,
                                          load_.next_corner_ns(t_ns_), row_end_ns()});
    EventExactStretch s{.duration_ns = end_ns - t_ns_,
                        .torque_reference = reference.torque,
                        .reference_slope = reference.slope,
                        .u_dc = parameters_.u_dc,
                        .tau_l = load_.torque(t_ns_ + (end_ns - t_ns_) / 2),
                        .imposed_speed = load_.imposes_speed()};
    if (s.imposed_speed) {
      // Slopes leave rounding errors; more is a jump, which acts at its instant.
      if (std::abs(load_.speed(t_ns_) - system_.plant().omega_m()) > 1e-6)
        system_.set_speed(load_.speed(t_ns_));
      // Up to the corner, where the profile may jump.
      const double left = load_.speed(end_ns - 1);
      s.speed_slope = (left - system_.plant().omega_m()) / (double(s.duration_ns) * 1e-9);
    }
    return s;
  }

  [[nodiscard]] bool run_stretch() {
    const EventExactStretch stretch = next_stretch();
    elapsed_ = 0.0;
    before_ = sample();
    before_.torque_reference = stretch.torque_reference;
    if (trace_) trace_->begin(system_, stretch.tau_l);
    tau_l_ = stretch.tau_l;
    const std::int64_t row_end = row_end_ns();
    const bool good = simulation_.run(
        stretch, [this](double duration) { return observe(duration); }, [this] { note_switching(); });
    result_.plant_reachable = system_.plant().is_reachable();
    if (!good || !result_.plant_reachable) {
      t_ns_ += std::llround(elapsed_ * 1e9);
      return false;
    }
    t_ns_ = result_.faults.any() ? result_.fault_ns : t_ns_ + stretch.duration_ns;
    const bool last = t_ns_ >= scenario_.duration_ns || result_.faults.any();
    if (trace_ && (t_ns_ == row_end || last)) trace_->finish_row(t_ns_, system_);
    return true;
  }

  /// False once the plant has left what its link can feed, which is not recorded, or a protection has
  /// tripped.
  bool observe(double duration) {
    if (!system_.plant().is_reachable()) return false;
    elapsed_ += duration;
    const MetricsSample after = sample();
    metrics_.add_segment(before_, after);
    note_pulses();
    if (trace_) trace_->add(system_, duration);
    protect(before_, after);
    before_ = after;
    return !result_.faults.any();
  }

  /// Those that began as the piece did.
  void note_pulses() {
    const std::int64_t pulses = system_.comparators().torque_pulses();
    if (pulses == pulses_) return;
    metrics_.pulse(before_.t_ns, pulses - pulses_);
    pulses_ = pulses;
  }

  void note_switching() {
    metrics_.commutate(before_.t_ns, system_.comparators().state());
    before_.p_dc = parameters_.u_dc * system_.plant().i_dc();
    if (trace_) trace_->begin(system_, tau_l_);
  }

  /// End of the trace's present row. [ns]
  [[nodiscard]] std::int64_t row_end_ns() const {
    return trace_ ? trace_->row_end_ns(t_ns_) : std::numeric_limits<std::int64_t>::max();
  }

  [[nodiscard]] MetricsSample sample() const {
    const EventExactSystem::Plant& plant = system_.plant();
    const PlantLook look{plant, plant.state(), EventExactSystem::meter};
    MetricsSample sample = look.metrics_sample();
    sample.p_dc = look.power(plant.u_s());
    const double elapsed_ns = elapsed_ * 1e9;
    const auto whole_ns = static_cast<std::int64_t>(elapsed_ns);
    sample.t_ns = t_ns_ + whole_ns;
    sample.fraction_ns = elapsed_ns - double(whole_ns);
    sample.torque_reference = system_.reference();
    sample.speed_reference = reference_.speed(sample.t_ns);
    return sample;
  }

  /// At the beginning of each control period within a piece without an event, over which the currents run in
  /// straight lines: where a piece ends depends on the rows of a trace.
  void protect(const MetricsSample& begin, const MetricsSample& end) {
    for (; next_protection_ns_ <= end.t_ns && !result_.faults.any();
         next_protection_ns_ += parameters_.protection.period_ns) {
      const double span = double(end.t_ns - begin.t_ns);
      const double share = span > 0.0 ? double(next_protection_ns_ - begin.t_ns) / span : 1.0;
      const SpaceVector<> i_s = begin.i_s + share * (end.i_s - begin.i_s);
      const double omega_m = std::lerp(begin.omega_m, end.omega_m, share);
      faults_.step(protection_.step({inverse_clarke(i_s), parameters_.u_dc, omega_m, {}, true}));
      result_.note_faults(faults_.latched(), faults_.first(), next_protection_ns_);
    }
  }

  [[nodiscard]] MilResult finish() {
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin_;
    result_.metrics = metrics_.metrics();
    result_.metrics[Metric::dwell_limited] = double(simulation_.dwell_limited());
    result_.metrics[Metric::simulated] = double(t_ns_) * 1e-9;
    result_.metrics[Metric::wall] = wall.count();
    result_.metrics[Metric::realtime_factor] = result_.metrics[Metric::simulated] / wall.count();
    result_.window_metrics = metrics_.window_metrics(result_.metrics);
    result_.cycle_departure = metrics_.cycle_departure();
    result_.final_state = result_.faults.any() ? DriveState::fault : DriveState::torque;
    return result_;
  }

  const EventExactRunner::Parameters& parameters_;
  const Scenario& scenario_;
  std::chrono::steady_clock::time_point begin_{std::chrono::steady_clock::now()};
  EventExactReference reference_;
  MechanicalLoad load_;
  Protection<> protection_;
  FaultMemory faults_{};
  RunMetrics metrics_;
  EventExactSystem system_;
  EventExactSimulation<Engine> simulation_;
  MilResult result_{};
  std::int64_t t_ns_{0};  ///< beginning of the stretch [ns]
  double elapsed_{0};     ///< since then [s]
  double tau_l_{0};       ///< load torque of the stretch [N·m]
  std::optional<EventExactTrace> trace_{};
  MetricsSample before_{};
  std::int64_t pulses_{0};
  std::int64_t next_protection_ns_{0};  ///< when the protections are next evaluated [ns]
};

}  // namespace

MilResult EventExactRunner::run(const Scenario& scenario, TraceRecorder* trace,
                                const MilRunner::Progress& progress) {
  const double max_step = double(parameters_.event_exact.max_step_ns) * 1e-9;
  if (parameters_.integrator == IntegratorKind::cvode) {
    CvodeEventEngine engine{parameters_.cvode, max_step};
    return EventExactRun{parameters_, scenario, engine, trace}.run(progress);
  }
  FixedStepEventEngine engine{max_step};
  return EventExactRun{parameters_, scenario, engine, trace}.run(progress);
}

}  // namespace sextant
