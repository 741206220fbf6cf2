#pragma once

#include <cstddef>

#include "semihosting.hpp"
#include "startup.hpp"

/// Tells the host the most that the stack has held.
inline void report_stack() {
  char text[] = "stack 00000 bytes\n";
  std::size_t digit = 10;
  for (std::size_t n = stack_used(); n > 0 && digit > 5; n /= 10) text[digit--] = char('0' + n % 10);
  semihosting::print(text);
}
