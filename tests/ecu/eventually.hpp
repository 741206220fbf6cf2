#pragma once

#include <chrono>
#include <thread>

namespace sextant::test {

/// Waits until it holds; false when it does not within a minute. A machine that others load, or that stands
/// still, may need a good part of that; a test whose condition holds does not.
template <class Condition>
[[nodiscard]] bool eventually(Condition&& holds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes{1};
  while (std::chrono::steady_clock::now() < end) {
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  return holds();
}

}  // namespace sextant::test
