#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <future>
#include <thread>
#include <type_traits>
#include <vector>

namespace sextant {

/// Calls work(0) … work(count − 1) on so many threads, and handle(result) on the caller's, in this order.
/// work: returns a result, from any thread and beside others. handle: takes a std::future of it, and returns
/// whether the rest is wanted; what it throws is thrown on. Then no further work begins; what runs is waited
/// for.
template <class Work, class Handle>
void in_order(std::size_t count, std::size_t threads, const Work& work, const Handle& handle) {
  using Result = std::invoke_result_t<const Work&, std::size_t>;
  std::vector<std::promise<Result>> results(count);
  std::atomic<std::size_t> next{0};
  const auto work_on = [&] {
    for (std::size_t k = next++; k < count; k = next++) {
      try {
        results[k].set_value(work(k));
      } catch (...) {
        results[k].set_exception(std::current_exception());
      }
    }
  };
  struct Workers {
    std::atomic<std::size_t>& next;
    std::size_t count;
    std::vector<std::jthread> threads{};
    ~Workers() { next = count; }  // the threads are joined after it
  } workers{next, count};
  for (std::size_t n = 0; n < std::min(threads, count); ++n) workers.threads.emplace_back(work_on);
  for (std::promise<Result>& result : results) {
    if (!handle(result.get_future())) return;
  }
}

}  // namespace sextant
