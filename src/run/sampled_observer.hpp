#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/plant/energy_meter.hpp"
#include "sextant/power_stage/segment_log.hpp"
#include "sextant/recording/trace_recorder.hpp"
#include "sextant/run/plant_look.hpp"
#include "sextant/run/run_metrics.hpp"
#include "sextant/run/scenario_commands.hpp"

namespace sextant {

/// What is observed of a sampled run: the gate segments between its control periods, and its periods.
template <class Io>
class SampledObserver {
 public:
  SampledObserver(const Scenario& scenario, std::int64_t period_ns, const Io& io,
                  const Controller<>* controller, TraceRecorder* trace)
      : metrics_{scenario},
        io_{io},
        controller_{controller},
        comparators_{dynamic_cast<const DirectTorqueController<>*>(controller)},
        trace_{trace},
        period_ns_{period_ns} {
    metrics_.has_control_period(period_ns);
    if (comparators_ == nullptr) metrics_.has_no_pulses();
  }

  /// A control period that has run, before time zero too; `now` is its telemetry.
  void period(const Telemetry<double>& now, const ScenarioCommands& commands) {
    temperatures_ = io_.temperatures();
    metrics_.note_temperatures(now.t_ns, temperatures_);
    note_losses(now.t_ns);
    if (now.t_ns > 0) add_segments(commands);
    note_comparators(now.t_ns);
    t_ns_ = now.t_ns;
    reference_ = commands.reference(now.t_ns);
    reference_slope_ = commands.reference_slope(now.t_ns);
    metrics_.begin_period(now, reference_);
    if (trace_ != nullptr && now.t_ns >= 0)
      trace_->add(now, trace_sample(look(io_.plant().state()), io_.plant().inputs().state, io_.plant().u_s()),
                  control_sample());
  }

  [[nodiscard]] const RunMetrics& metrics() const noexcept { return metrics_; }

 private:
  /// The segments applied since the last period. The reference runs in a line from that period on;
  /// what jumps between two periods acts with the second.
  void add_segments(const ScenarioCommands& commands) {
    const auto instants = io_.log().instants();
    const bool is_averaged = !io_.averaged().empty();
    if (is_averaged) [[unlikely]]
      commutate(io_.averaged());
    std::int64_t elapsed_ns = 0;
    std::size_t at = 0;  // the instant that is looked at
    PlantLook begin = look(instants[at]);
    MetricsSample before = metrics_sample(begin, elapsed_ns, commands);
    for (const ActedSegment& segment : io_.log().segments()) {
      if (segment.begin != at) {  // the state has jumped
        begin = look(instants[segment.begin]);
        before = metrics_sample(begin, elapsed_ns, commands);
      }
      at = segment.end;
      before.p_dc = begin.power(segment.u_s_begin) + drawn_power();
      if (!is_averaged) [[likely]]
        metrics_.commutate(before.t_ns, segment.state);
      elapsed_ns += segment.duration_ns;
      const PlantLook end = look(instants[at]);
      MetricsSample after = metrics_sample(end, elapsed_ns, commands);
      after.p_dc = end.power(segment.u_s_end) + drawn_power();
      metrics_.add_segment(before, after);
      if (trace_ != nullptr)
        trace_->add_segment(trace_sample(begin, segment.state, segment.u_s_begin),
                            trace_sample(end, segment.state, segment.u_s_end),
                            double(segment.duration_ns) * 1e-9);
      begin = end;
      before = after;
    }
  }

  /// The edges of segments since the last period.
  void commutate(std::span<const GateSegment> acted) noexcept {
    std::int64_t t_ns = t_ns_;
    for (const GateSegment& segment : acted) {
      metrics_.commutate(t_ns, segment.state);
      t_ns += segment.duration_ns;
    }
  }

  /// Those over the segments before this instant.
  void note_losses(std::int64_t t_ns) {
    const InverterLosses* losses = io_.losses();
    if (losses == nullptr) return;
    lost_before_ = lost_;
    lost_ = losses->energies();
    metrics_.note_inverter(t_ns, losses->hottest_junction(), losses->case_temperature());
  }

  /// With what the inverter has lost, at a share of the last control period.
  void add_losses(DriveEnergies& energies, double share) const noexcept {
    if (io_.losses() == nullptr) return;
    const InverterEnergies step = lost_ - lost_before_;
    energies.inverter =
        InverterEnergies{lost_before_.lost + share * step.lost, lost_before_.drawn + share * step.drawn};
    energies.link += energies.inverter->drawn;
  }
  /// Drawn over the last control period for losses. [W]
  [[nodiscard]] double drawn_power() const noexcept {
    return (lost_.drawn - lost_before_.drawn) / (double(period_ns_) * 1e-9);
  }

  /// A pulse begins where the output becomes +1 or −1.
  void note_comparators(std::int64_t t_ns) {
    if (comparators_ == nullptr) return;
    const int demand = comparators_->torque_demand();
    if (demand != 0 && demand != demand_ && t_ns >= 0) metrics_.pulse(t_ns);
    demand_ = demand;
  }

  /// Without the link's power, which jumps where the inverter switches.
  [[nodiscard]] MetricsSample metrics_sample(const PlantLook& now, std::int64_t elapsed_ns,
                                             const ScenarioCommands& commands) const noexcept {
    MetricsSample sample = now.metrics_sample();
    sample.t_ns = t_ns_ + elapsed_ns;
    add_losses(sample.energies, double(elapsed_ns) / double(period_ns_));
    sample.torque_reference = reference_ + reference_slope_ * (double(elapsed_ns) * 1e-9);
    sample.speed_reference = commands.speed_reference(sample.t_ns);
    return sample;
  }

  [[nodiscard]] PlantSample trace_sample(const PlantLook& now, SwitchState state,
                                         SpaceVector<> u_s) const noexcept {
    PlantSample sample = now.trace_sample(state, u_s, io_.tau_l());
    sample.temperatures = temperatures_;
    if (const InverterLosses* losses = io_.losses()) {
      add_losses(sample.energies, 1.0);
      sample.inverter = {losses->power(), losses->case_temperature(), losses->junction_temperatures()};
    }
    return sample;
  }

  [[nodiscard]] PlantLook look(const typename Io::PlantType::State& x) const noexcept {
    return {io_.plant(), x, meter};
  }

  [[nodiscard]] ControlSample control_sample() const noexcept {
    ControlSample sample;
    if (controller_ != nullptr) sample.channels = controller_->channel_values();
    if (comparators_ == nullptr) return sample;
    sample.torque_comparator = std::int8_t(comparators_->torque_demand());
    sample.flux_comparator = std::int8_t(comparators_->flux_demand() ? 1 : 0);
    return sample;
  }

  /// Index of the energy meter's first state.
  static constexpr int meter = Io::PlantType::size - EnergyMeter<>::size;

  RunMetrics metrics_;
  const Io& io_;
  const Controller<>* controller_;
  const DirectTorqueController<>* comparators_;  // the same, where it is one
  TraceRecorder* trace_;
  ThermalNodes<double> temperatures_{};  ///< over the segments before it [°C]
  InverterEnergies lost_{};              ///< by the inverter, at the end of them
  InverterEnergies lost_before_{};       ///< at their beginning
  std::int64_t period_ns_;               ///< from one control period to the next [ns]
  std::int64_t t_ns_{0};                 ///< the last period [ns]
  double reference_{0};                  ///< torque reference from there on [N·m]
  double reference_slope_{0};            ///< [N·m/s]
  int demand_{0};                        ///< the torque comparator's last output
};

}  // namespace sextant
