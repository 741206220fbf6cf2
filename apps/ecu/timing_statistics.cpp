#include "ecu/timing_statistics.hpp"

#include <algorithm>
#include <iterator>

namespace sextant::ecu {

void TimingHistograms::add(const WakeRecord& wake) noexcept {
  latency.record(wake.latency_ns);
  body.record(wake.body_ns);
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
  if (wake.overrun) add_miss(wake);
}

void TimingStatistics::add(const StageRecord& stages_ns) noexcept {
  interval_.add(stages_ns);
  total_.add(stages_ns);
}

void TimingStatistics::add_miss(const WakeRecord& wake) {
  // The deadline slept for: what was skipped lies between it and the one that was served.
  const std::int64_t skipped_ns = wake.latency_ns - wake.latency_ns % parameters_.wake_period_ns;
  Miss miss{.t_ns = wake.deadline_ns - skipped_ns,
            .latency_ns = wake.latency_ns,
            .gap = wake.gap,
            .body_overran = wake.body_overran};
  miss.cause = visible_cause(miss, parameters_.wake_period_ns);
  if (miss.cause != MissCause::stage_gap) {
    count(miss);
    return;
  }
  pending_.push_back(miss);
  give_up_waiting(miss.t_ns);
}

void TimingStatistics::give_up_waiting(std::int64_t now_ns) {
  const auto waits_on = [&](const Miss& miss) { return miss.t_ns > now_ns - longest_wait_ns; };
  auto young = std::ranges::find_if(pending_, waits_on);
  if (std::ssize(pending_) > most_waiting) young = std::max(young, pending_.end() - most_waiting);
  std::for_each(pending_.begin(), young, [this](const Miss& miss) { count(miss); });
  pending_.erase(pending_.begin(), young);
}

void TimingStatistics::add(const SchedulerSample& sample) {
  const SchedulerSample growth = sample.since(scheduler_);
  SchedulerSample unspent = growth.and_left_over(left_over_);
  scheduler_ = sample;
  const auto later = std::ranges::find_if(
      pending_, [&sample](const Miss& miss) { return miss.t_ns + miss.latency_ns > sample.t_ns; });
  for (auto miss = pending_.begin(); miss != later; ++miss) {
    if (unspent.explains(miss->gap.longest_ns)) {
      unspent.spend(miss->gap.longest_ns);
      miss->cause = MissCause::machine_gap;
    }
    count(*miss);
  }
  pending_.erase(pending_.begin(), later);
  left_over_ = unspent.at_most(growth);
}

void TimingStatistics::finish() {
  for (const Miss& miss : pending_) count(miss);
  pending_.clear();
}

void TimingStatistics::count(const Miss& miss) {
  ++causes_[static_cast<std::size_t>(miss.cause)];
  if (miss.cause == MissCause::late_wake || miss.cause == MissCause::own_body) ++without_gap_;
  const auto place =
      std::ranges::find_if(worst_, [&miss](const Miss& known) { return known.latency_ns < miss.latency_ns; });
  worst_.insert(place, miss);
  if (worst_.size() > worst_kept) worst_.pop_back();
}

}  // namespace sextant::ecu
