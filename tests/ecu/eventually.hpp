#pragma once

#include <chrono>
#include <thread>

namespace sextant::test {

/// Waits until it holds; false when it does not within ten seconds, which a loaded machine may need.
template <class Condition>
[[nodiscard]] bool eventually(Condition&& holds) {
  for (int i = 0; i < 10'000; ++i) {
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  return holds();
}

}  // namespace sextant::test
