#include "ecu/virtual_time/timed_changes.hpp"

#include <exception>
#include <map>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "common/request_text.hpp"

namespace sextant::ecu {

TimedChanges::TimedChanges(const std::vector<TimedOverride>& at, ParameterChanges& changes,
                           const VirtualClock& clock, std::string prefix)
    : changes_{changes}, clock_{clock}, prefix_{std::move(prefix)} {
  std::map<std::int64_t, std::vector<std::string>> by_time;
  for (const TimedOverride& change : at) {
    if (change.given.counts_for(changes.config().drive_id)) by_time[change.t_ns].push_back(change.given.text);
  }
  for (auto& [t_ns, overrides] : by_time) sets_.push_back({t_ns, std::move(overrides)});
  due_ns_ = sets_.empty() ? never_ns : sets_.front().t_ns;
}

void TimedChanges::refuse(std::int64_t t_ns, const std::string& why) const {
  throw std::runtime_error{fmt::format("--set-at {:g}: {}{}", double(t_ns) * 1e-9, prefix_, why)};
}

VirtualParty TimedChanges::party() {
  return {.next_due_ns = [this] { return due_ns_; }, .act = [this] { act(); }};
}

void TimedChanges::act() {
  waits_ ? look(sets_[next_]) : offer(sets_[next_]);
  if (waits_) {
    due_ns_ = clock_.now_ns() + changes_.config().drive.drive.period_ns;
    return;
  }
  ++next_;
  due_ns_ = next_ < sets_.size() ? sets_[next_].t_ns : never_ns;
}

void TimedChanges::require_all() const {
  if (next_ == sets_.size()) return;
  const std::int64_t t_ns = sets_[next_].t_ns;
  if (waits_) refuse(t_ns, "the run ended before the drive took it");
  refuse(t_ns, fmt::format("the run ended before it, at {:g} s", double(clock_.now_ns()) * 1e-9));
}

void TimedChanges::offer(const Set& set) {
  offered_ns_ = clock_.now_ns();
  try {
    waits_ = changes_.offer(set.overrides);
  } catch (const std::exception& problem) {
    refuse(set.t_ns, problem_text(problem));
  }
}

void TimedChanges::look(const Set& set) {
  const ParameterChanges::Outcome outcome = changes_.outcome();
  if (outcome == ParameterChanges::Outcome::refused) refuse(set.t_ns, not_at_rest(changes_.changes()));
  waits_ = outcome == ParameterChanges::Outcome::waits;
  if (!waits_) {
    report_.push_back(fmt::format("{}parameters {} at {:g} s: {}", prefix_, changes_.number(),
                                  double(offered_ns_) * 1e-9, to_string(changes_.changes())));
  }
}

}  // namespace sextant::ecu
