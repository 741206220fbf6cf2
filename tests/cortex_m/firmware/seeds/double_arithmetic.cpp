// A violation that no warning shows: everything is double on purpose.
#include "sextant/core/space_vector.hpp"
#include "startup.hpp"

volatile double seed = 1.0;

void run_firmware() {
  const sextant::SpaceVector<double> x{seed, seed};
  seed = dot(x, x);
  for (;;) asm volatile("wfi");
}
