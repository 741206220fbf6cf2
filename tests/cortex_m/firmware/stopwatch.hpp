#pragma once

#include <cstdint>

#include "sys_tick.hpp"

namespace sextant::golden {

/// Time stands still but for instructions: `-icount` advances the timer by a fixed amount for each.
class Stopwatch {
 public:
  void start() { begin_ = SysTick::instance().current; }
  [[nodiscard]] std::uint32_t ticks() const { return (begin_ - SysTick::instance().current) & SysTick::mask; }

 private:
  std::uint32_t begin_{};
};

}  // namespace sextant::golden
