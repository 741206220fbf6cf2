#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "sextant/control/flux_torque_estimator.hpp"

namespace sextant {
namespace {

constexpr unsigned seed = 20240506;

/// The kind `voltage_model`, at 530 V.
template <class T>
class VoltageModelKindOf : public testing::Test {
 protected:
  static constexpr T tolerance = T(1000) * std::numeric_limits<T>::epsilon();
  static constexpr T u_dc = T(530);
  using Estimator = FluxTorqueEstimator<T>;

  static void step(Estimator& estimator, const GatePattern& applied, SpaceVector<T> i_s) {
    Measurement<T> m;
    m.u_dc = u_dc;
    m.applied = applied;
    m.i_abc = inverse_clarke(i_s);
    estimator.step(m);
  }

  InductionMachineParameters<T> machine{};
  Estimator estimator{{.machine = machine, .kind = FluxEstimatorKind::voltage_model}};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(VoltageModelKindOf, Scalars);

TYPED_TEST(VoltageModelKindOf, WithoutCurrentTheFluxIsTheVoltSeconds) {
  using T = TypeParam;
  for (int i = 0; i < 100; ++i) this->step(this->estimator, {switch_states[1], 25'000}, {});
  EXPECT_NEAR(this->estimator.psi_s().alpha, T(2) / T(3) * this->u_dc * T(2.5e-3), this->tolerance);
  EXPECT_NEAR(this->estimator.psi_s().beta, T(0), this->tolerance);
}

// Under a linear current the trapezoidal rule is exact: ψ = u t − R_s (i_0 + i_1) t/2.
TYPED_TEST(VoltageModelKindOf, ALinearCurrentIsIntegratedExactly) {
  using T = TypeParam;
  for (int i = 0; i <= 40; ++i) {
    this->step(this->estimator, {switch_states[7], 25'000}, {T(0.5) * T(i), T(-0.25) * T(i)});
  }
  const T half = T(0.5) * this->machine.r_s * T(41) * T(25e-6);
  EXPECT_NEAR(this->estimator.psi_s().alpha, -half * T(20) * T(40) / T(41), this->tolerance);
  EXPECT_NEAR(this->estimator.psi_s().beta, half * T(10) * T(40) / T(41), this->tolerance);
}

TYPED_TEST(VoltageModelKindOf, APatternOfManySegmentsActsAsTheirSum) {
  using T = TypeParam;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random{seed};
  std::uniform_int_distribution<unsigned> any_state{0, 7};
  std::uniform_int_distribution<std::int32_t> any_duration{0, 10'000};
  std::uniform_real_distribution<T> any_current{T(-50), T(50)};
  for (int i = 0; i < 200; ++i) {
    const SpaceVector<T> i_s{any_current(random), any_current(random)};
    typename TestFixture::Estimator one_by_one = this->estimator;
    typename TestFixture::Estimator at_once = this->estimator;
    const GatePattern none{switch_states[0], 0};
    this->step(one_by_one, none, i_s);
    this->step(at_once, none, i_s);
    GatePattern pattern;
    for (std::size_t k = 0; k < GatePattern::capacity; ++k) {
      const GateSegment segment{switch_states[any_state(random)], any_duration(random)};
      pattern.append(segment);
      this->step(one_by_one, {segment.state, segment.duration_ns}, i_s);
    }
    this->step(at_once, pattern, i_s);
    EXPECT_NEAR(at_once.psi_s().alpha, one_by_one.psi_s().alpha, this->tolerance);
    EXPECT_NEAR(at_once.psi_s().beta, one_by_one.psi_s().beta, this->tolerance);
  }
}

}  // namespace
}  // namespace sextant
