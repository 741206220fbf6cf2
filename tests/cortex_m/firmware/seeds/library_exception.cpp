// A violation: a function of the library that throws.
#include <array>

#include "startup.hpp"

volatile unsigned seed = 3;

void run_firmware() {
  const std::array<unsigned, 2> numbers{1, 2};
  seed = numbers.at(seed);
  for (;;) asm volatile("wfi");
}
