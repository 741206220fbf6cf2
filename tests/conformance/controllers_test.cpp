// Every controller of Sextant conforms, in both scalars.
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "conformance/types_of.hpp"
#include "sextant/config/control_methods.hpp"
#include "sextant/conformance/check_controller.hpp"

namespace sextant {
namespace {

template <class C, class T>
void expect_conformance(bool has_flux_reference = true) {
  for (const std::uint64_t seed :
       {std::uint64_t{1}, std::uint64_t{2}, std::uint64_t{std::random_device{}()}}) {
    const ConformanceResult result =
        check_controller<C, T>({}, {.seed = seed, .has_flux_reference = has_flux_reference});
    EXPECT_THAT(result.violations, testing::IsEmpty());
  }
}

template <class C>
class Controllers : public testing::Test {};
TYPED_TEST_SUITE(Controllers, test::TypesOf<ControllerList<double>>::Types);
TYPED_TEST(Controllers, Conform) {
  expect_conformance<TypeParam, double>();
}

template <class C>
class FloatControllers : public testing::Test {};
TYPED_TEST_SUITE(FloatControllers, test::TypesOf<ControllerList<float>>::Types);
TYPED_TEST(FloatControllers, Conform) {
  expect_conformance<TypeParam, float>();
}

template <class C>
class CommissioningControllers : public testing::Test {};
TYPED_TEST_SUITE(CommissioningControllers, test::TypesOf<CommissioningList<double>>::Types);
TYPED_TEST(CommissioningControllers, Conform) {
  expect_conformance<TypeParam, double>(false);
}

template <class C>
class FloatCommissioningControllers : public testing::Test {};
TYPED_TEST_SUITE(FloatCommissioningControllers, test::TypesOf<CommissioningList<float>>::Types);
TYPED_TEST(FloatCommissioningControllers, Conform) {
  expect_conformance<TypeParam, float>(false);
}

}  // namespace
}  // namespace sextant
