#include "ecu/timing/timing_statistics.hpp"

#include <algorithm>
#include <iterator>

namespace sextant::ecu {

void TimingHistograms::add(const WakeRecord& wake) noexcept {
  latency.record(wake.latency_ns);
  execution.record(wake.execution_ns);
  if (wake.command_to_gate_ns > 0) command_to_gate.record(wake.command_to_gate_ns);
  longest_gap_ns = std::max(longest_gap_ns, wake.longest_gap_ns);
}

void TimingHistograms::add(const StageRecord& stages_ns) noexcept {
  for (std::size_t i = 0; i < stage_count; ++i) stages[i].record(stages_ns[i]);
}

void TimingStatistics::add(const WakeRecord& wake) {
  interval_.add(wake);
  total_.add(wake);
  last_ = wake;
  if (wake.longest_gap_ns > parameters_.gap_limit_ns) ++gaps_;
  if (wake.overrun) add_overrun(wake);
}

void TimingStatistics::add(const StageRecord& stages_ns) noexcept {
  interval_.add(stages_ns);
  total_.add(stages_ns);
}

void TimingStatistics::add_overrun(const WakeRecord& wake) {
  // The deadline of the wait: the missed periods lie between it and the deadline served.
  const std::int64_t missed_ns = wake.latency_ns - wake.latency_ns % parameters_.wake_period_ns;
  Overrun overrun{.t_ns = wake.deadline_ns - missed_ns,
                  .latency_ns = wake.latency_ns,
                  .gap = wake.gap,
                  .execution_overran = wake.execution_overran};
  overrun.cause = visible_cause(overrun, parameters_.wake_period_ns);
  if (overrun.cause != OverrunCause::stage_gap) {
    count(overrun);
    return;
  }
  pending_.push_back(overrun);
  count_expired(overrun.t_ns);
}

void TimingStatistics::count_expired(std::int64_t now_ns) {
  const auto waits_on = [&](const Overrun& overrun) { return overrun.t_ns > now_ns - longest_wait_ns; };
  auto young = std::ranges::find_if(pending_, waits_on);
  if (std::ssize(pending_) > most_waiting) young = std::max(young, pending_.end() - most_waiting);
  std::for_each(pending_.begin(), young, [this](const Overrun& overrun) { count(overrun); });
  pending_.erase(pending_.begin(), young);
}

void TimingStatistics::add(const SchedulerSample& sample) {
  const SchedulerSample growth = sample.since(scheduler_);
  SchedulerSample unspent = growth.and_left_over(left_over_);
  scheduler_ = sample;
  const auto later = std::ranges::find_if(pending_, [&sample](const Overrun& overrun) {
    return overrun.t_ns + overrun.latency_ns > sample.t_ns;
  });
  for (auto overrun = pending_.begin(); overrun != later; ++overrun) {
    if (unspent.explains(overrun->gap.longest_ns)) {
      unspent.spend(overrun->gap.longest_ns);
      overrun->cause = OverrunCause::machine_gap;
    }
    count(*overrun);
  }
  pending_.erase(pending_.begin(), later);
  left_over_ = unspent.at_most(growth);
}

void TimingStatistics::finish() {
  for (const Overrun& overrun : pending_) count(overrun);
  pending_.clear();
}

void TimingStatistics::count(const Overrun& overrun) {
  ++causes_[static_cast<std::size_t>(overrun.cause)];
  if (overrun.cause == OverrunCause::late_wake || overrun.cause == OverrunCause::long_execution)
    ++without_gap_;
  const auto place = std::ranges::find_if(
      worst_, [&overrun](const Overrun& known) { return known.latency_ns < overrun.latency_ns; });
  worst_.insert(place, overrun);
  if (worst_.size() > worst_kept) worst_.pop_back();
}

}  // namespace sextant::ecu
