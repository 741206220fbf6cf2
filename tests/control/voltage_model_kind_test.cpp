#include "sextant/control/voltage_model.hpp"

#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr unsigned seed = 20240506;

template <class T>
class VoltageModelOf : public testing::Test {
 protected:
  static constexpr T tolerance = T(1000) * std::numeric_limits<T>::epsilon();
  static constexpr T r_s = T(0.435);
  static constexpr T u_dc = T(530);
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(VoltageModelOf, Scalars);

TYPED_TEST(VoltageModelOf, WithoutCurrentTheFluxIsTheVoltSeconds) {
  using T = TypeParam;
  VoltageModel<T> model{this->r_s};
  for (int i = 0; i < 100; ++i) model.step(GatePattern{switch_states[1], 25'000}, this->u_dc, {}, {});
  EXPECT_NEAR(model.psi_s().alpha, T(2) / T(3) * this->u_dc * T(2.5e-3), this->tolerance);
  EXPECT_NEAR(model.psi_s().beta, T(0), this->tolerance);
}

// Under a linear current the trapezoidal rule is exact: ψ = u t − R_s (i_0 + i_1) t/2.
TYPED_TEST(VoltageModelOf, ALinearCurrentIsIntegratedExactly) {
  using T = TypeParam;
  VoltageModel<T> model{this->r_s};
  const auto current = [](int i) { return SpaceVector<T>{T(0.5) * T(i), T(3) - T(0.25) * T(i)}; };
  const GatePattern zero{switch_states[7], 25'000};
  for (int i = 0; i < 40; ++i) model.step(zero, this->u_dc, current(i), current(i + 1));
  EXPECT_NEAR(model.psi_s().alpha, -this->r_s * T(10) * T(1e-3), this->tolerance);
  EXPECT_NEAR(model.psi_s().beta, -this->r_s * T(-2) * T(1e-3), this->tolerance);
}

TYPED_TEST(VoltageModelOf, APatternOfManySegmentsActsAsTheirSum) {
  using T = TypeParam;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  std::uniform_int_distribution<unsigned> any_state{0, 7};
  std::uniform_int_distribution<std::int32_t> any_duration{0, 10'000};
  std::uniform_real_distribution<T> any_current{T(-50), T(50)};
  for (int i = 0; i < 200; ++i) {
    const SpaceVector<T> i_s{any_current(random), any_current(random)};
    GatePattern pattern;
    VoltageModel<T> one_by_one{this->r_s};
    for (std::size_t k = 0; k < GatePattern::capacity; ++k) {
      const GateSegment segment{switch_states[any_state(random)], any_duration(random)};
      pattern.append(segment);
      one_by_one.step(GatePattern{segment.state, segment.duration_ns}, this->u_dc, i_s, i_s);
    }
    VoltageModel<T> at_once{this->r_s};
    at_once.step(pattern, this->u_dc, i_s, i_s);
    EXPECT_NEAR(at_once.psi_s().alpha, one_by_one.psi_s().alpha, this->tolerance);
    EXPECT_NEAR(at_once.psi_s().beta, one_by_one.psi_s().beta, this->tolerance);
  }
}

TYPED_TEST(VoltageModelOf, ContinuesFromTheFluxThatItIsGiven) {
  using T = TypeParam;
  VoltageModel<T> model{this->r_s};
  model.set({T(0.5), T(-0.25)});
  model.step(GatePattern{switch_states[0], 25'000}, this->u_dc, {}, {});
  EXPECT_EQ(model.psi_s(), (SpaceVector<T>{T(0.5), T(-0.25)}));
}

}  // namespace
}  // namespace sextant
