#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "plant/switching_run.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/erk_integrator.hpp"
#include "support/allocation_counter.hpp"

namespace sextant {
namespace {

using Plant = DrivePlant<double>;

template <class Integrator>
void expect_none_after_construction(const typename Integrator::Parameters& parameters) {
  PlantInputs<double> inputs{};
  inputs.u_dc = 530.0;
  const std::uint64_t before_construction = testing::allocations();
  Integrator integrator{parameters};
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

TEST(CvodeAllocation, NoneAfterConstruction) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "a sanitizer has its own allocator";
  for (const CvodeMethod method : {CvodeMethod::adams_fixed_point, CvodeMethod::bdf_newton}) {
    SCOPED_TRACE(int(method));
    CvodeParameters parameters{};
    parameters.method = method;
    expect_none_after_construction<CvodeIntegrator<Plant>>(parameters);
  }
}

TEST(ErkAllocation, NoneAfterConstruction) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "a sanitizer has its own allocator";
  for (const double tolerance : {1e-6, 1e-13}) {
    SCOPED_TRACE(tolerance);
    ErrorControl parameters{};
    parameters.relative_tolerance = parameters.flux_tolerance = tolerance;
    expect_none_after_construction<ErkIntegrator<Plant>>(parameters);
  }
}

}  // namespace
}  // namespace sextant
