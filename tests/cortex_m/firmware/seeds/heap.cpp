// A violation: an object from the heap.
#include <vector>

#include "startup.hpp"

volatile unsigned seed = 3;

void run_firmware() {
  std::vector<unsigned> numbers(seed);
  seed = numbers[1];
  for (;;) asm volatile("wfi");
}
