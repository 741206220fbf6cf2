#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "support/allocation_counter.hpp"

namespace sextant {
namespace {

TEST(CvodeAllocation, NoneAfterConstruction) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "a sanitizer has its own allocator";
  using Plant = DrivePlant<double>;
  PlantInputs<double> inputs{};
  inputs.u_dc = 530.0;
  for (const CvodeMethod method : {CvodeMethod::adams_fixed_point, CvodeMethod::bdf_newton}) {
    SCOPED_TRACE(int(method));
    CvodeParameters parameters{};
    parameters.method = method;
    const std::uint64_t before_construction = testing::allocations();
    CvodeIntegrator<Plant> integrator{parameters};
    EXPECT_GT(testing::allocations() - before_construction, 10U) << "the counter does not count";
    Plant plant{DrivePlantParameters<double>{}};
    std::vector<SwitchState> sequence = switching_sequence(400, 31);
    for (std::size_t n = 100; n < 200; ++n) sequence[n] = gates_off;
    for (std::size_t n = 250; n < 300; ++n) sequence[n] = {LegState::off, sequence[n].b(), sequence[n].c()};
    const std::uint64_t before = testing::allocations();
    const bool good = run(plant, integrator, sequence, inputs);
    const std::uint64_t after = testing::allocations();
    EXPECT_TRUE(good);
    EXPECT_EQ(after, before);
  }
}

}  // namespace
}  // namespace sextant
