#pragma once

#include <cstdint>

/// The processor's own timer, a 24-bit counter that counts down.
/// Source: ARMv7-M Architecture Reference Manual (DDI 0403), B3.3.
struct SysTick {
  volatile std::uint32_t control;
  volatile std::uint32_t reload;
  volatile std::uint32_t current;

  static constexpr std::uint32_t mask = 0xFF'FFFF;
  static SysTick& instance() { return *reinterpret_cast<SysTick*>(0xE000'E010U); }

  /// Counts processor clocks from `reload` to zero over and over; `interrupt`: sys_tick_handler() at each
  /// zero.
  void start(std::uint32_t from, bool interrupt) {
    reload = from;
    current = 0;
    control = 5U | (interrupt ? 2U : 0U);
  }
};
