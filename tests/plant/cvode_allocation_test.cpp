#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/drive_plant.hpp"

// The sanitizers bring their own malloc.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && defined(__GLIBC__)

namespace {
std::atomic<long> allocations{0};
}  // namespace

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);

void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  ++allocations;
  return __libc_realloc(memory, size);
}
}

namespace sextant {
namespace {

TEST(CvodeAllocation, NoneAfterConstruction) {
  using Plant = DrivePlant<double>;
  PlantInputs<double> inputs{};
  inputs.u_dc = 530.0;
  for (const CvodeMethod method : {CvodeMethod::adams_fixed_point, CvodeMethod::bdf_newton}) {
    SCOPED_TRACE(int(method));
    CvodeParameters parameters{};
    parameters.method = method;
    const long before_construction = allocations;
    CvodeIntegrator<Plant> integrator{parameters};
    EXPECT_GT(allocations - before_construction, 10) << "the counter does not count";
    Plant plant{DrivePlantParameters<double>{}};
    std::vector<SwitchState> sequence = switching_sequence(400, 31);
    for (std::size_t n = 100; n < 200; ++n) sequence[n] = gates_off;
    for (std::size_t n = 250; n < 300; ++n) sequence[n].a = LegState::off;
    const long before = allocations;
    const bool good = run(plant, integrator, sequence, inputs);
    const long after = allocations;
    EXPECT_TRUE(good);
    EXPECT_EQ(after - before, 0);
  }
}

}  // namespace
}  // namespace sextant

#endif
