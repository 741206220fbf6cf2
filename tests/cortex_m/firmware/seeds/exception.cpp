// A violation: an exception.
#include "startup.hpp"

volatile unsigned seed = 3;

void run_firmware() {
  if (seed == 3) throw 3;
  for (;;) asm volatile("wfi");
}
