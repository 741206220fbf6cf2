// A violation: a float meets a double, and single-precision hardware computes by library.
#include "sextant/core/space_vector.hpp"
#include "startup.hpp"

volatile float seed = 1.0F;

void run_firmware() {
  const sextant::SpaceVector<float> x{seed, seed};
  seed = float(1.5 * dot(x, x));
  for (;;) asm volatile("wfi");
}
