#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "common/outcome.hpp"

namespace sextant {

/// Calls work(0) … work(count − 1) on so many threads as long as wants_more(), and handle(outcome) on the
/// caller's for each that has begun, in this order. wants_more: is not true again once it was false; asked
/// before each work begins. Returns when all that has begun is over and handled.
template <class Work, class WantsMore, class Handle>
void in_order(std::size_t count, std::size_t threads, const Work& work, const WantsMore& wants_more,
              const Handle& handle) {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::optional<Outcome<decltype(work(std::size_t{}))>>> outcomes(count);
  std::size_t next = 0;
  std::size_t end = count;
  const auto claim = [&]() -> std::optional<std::size_t> {
    const std::scoped_lock lock{mutex};
    if (!wants_more()) end = next;
    changed.notify_one();
    return next < end ? std::optional{next++} : std::nullopt;
  };
  const auto work_on = [&] {
    while (const std::optional<std::size_t> k = claim()) {
      auto outcome = outcome_of([&] { return work(*k); });
      const std::scoped_lock lock{mutex};
      outcomes[*k] = std::move(outcome);
      changed.notify_one();
    }
  };
  std::vector<std::jthread> workers;
  workers.reserve(std::min(threads, count));
  for (std::size_t n = 0; n < std::min(threads, count); ++n) workers.emplace_back(work_on);
  std::unique_lock lock{mutex};
  for (std::size_t k = 0; k < count; ++k) {
    changed.wait(lock, [&] { return outcomes[k].has_value() || k >= end; });
    const auto outcome = std::exchange(outcomes[k], std::nullopt);
    if (!outcome) return;
    lock.unlock();
    handle(*outcome);
    lock.lock();
  }
}

}  // namespace sextant
