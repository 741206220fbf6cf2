#include "sextant/drive/torque_capability.hpp"

#include <complex>
#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr double paper_flux = 1.1;
constexpr double paper_link = 530.0;
constexpr int slip_steps = 4000;  // up to the breakdown, where the reference looks for the limit

/// Stator voltage and torque of the T-equivalent circuit at electrical rotor speed and slip, solved for the
/// stator current that gives the stator flux.
struct Circuit {
  double voltage;
  double torque;

  Circuit(const InductionMachineParameters<>& m, double psi, double omega_r, double omega_slip) {
    using Complex = std::complex<double>;
    const Complex j{0.0, 1.0};
    // 0 = R_r i_r + j ω_slip (L_r i_r + L_m i_s) gives i_r by i_s, and ψ = L_s i_s + L_m i_r the rest.
    const Complex i_r_by_i_s = -j * omega_slip * m.l_m / (m.r_r + j * omega_slip * m.l_r());
    const Complex i_s = psi / (m.l_s() + m.l_m * i_r_by_i_s);
    voltage = std::abs(m.r_s * i_s + j * (omega_r + omega_slip) * psi);
    torque = 1.5 * m.pole_pairs * psi * i_s.imag();
  }
};

/// Largest torque of that sign that the voltage suffices for, by stepping the slip from zero; below zero
/// where it does not suffice for zero torque.
double largest_by_circuit(const InductionMachineParameters<>& m, double psi, double voltage, double omega_m,
                          double sign, double limit) {
  const double breakdown_slip = m.l_s() / (m.sigma_l_s() * m.tau_r());
  double largest = -1.0;
  for (int k = 0;; ++k) {
    const Circuit c{m, psi, m.pole_pairs * omega_m, sign * breakdown_slip * k / slip_steps};
    const double torque = sign * c.torque;
    if (c.voltage > voltage || torque < largest) return largest;  // too much voltage, or past the breakdown
    if (torque > limit) return limit;
    largest = torque;
  }
}

InductionMachineParameters<> large_machine() {
  return {.r_s = 0.012,
          .r_r = 0.009,
          .l_ls = 1.4e-4,
          .l_lr = 1.6e-4,
          .l_m = 5.2e-3,
          .pole_pairs = 3,
          .inertia = 4};
}

template <class T>
class TorqueCapabilityOf : public testing::Test {
 protected:
  /// The paper's machine and flux at the whole linear voltage.
  static TorqueCapability<T> paper() { return TorqueCapability<T>{{.voltage_use = T(1)}}; }
  static constexpr T link = T(paper_link);
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(TorqueCapabilityOf, Scalars);

TYPED_TEST(TorqueCapabilityOf, MeetsTheKnownLimitsOfThePapersMachine) {
  using T = TypeParam;
  const auto capability = this->paper();
  EXPECT_NEAR(capability.at(T(115), this->link).motoring, 130.0, 2.0);
  EXPECT_NEAR(capability.at(T(130), this->link).motoring, 50.0, 2.0);
  EXPECT_LT(capability.at(T(138.9), this->link).motoring, 5.0);
  EXPECT_TRUE(capability.at(T(138.9), this->link).holds_zero_torque);
  EXPECT_FALSE(capability.at(T(139.3), this->link).holds_zero_torque);
  EXPECT_EQ(capability.at(T(105), this->link).motoring, T(150));
}

TYPED_TEST(TorqueCapabilityOf, AgreesWithTheEquivalentCircuit) {
  using T = TypeParam;
  const struct {
    InductionMachineParameters<> machine;
    double psi;
    double u_dc;
    double torque;
    double top_speed;
  } cases[] = {{{}, paper_flux, paper_link, 150, 150},
               {{}, paper_flux, paper_link, 1000, 150},  // beyond the breakdown torque
               {{}, 0.5, 300, 60, 190},
               {{}, paper_flux, 60, 150, 20},
               {large_machine(), 0.9, 560, 1500, 130}};
  for (const auto& c : cases) {
    typename TorqueCapability<T>::Parameters p{
        .flux_reference = T(c.psi), .voltage_use = T(1), .torque = T(c.torque)};
    p.machine = {.r_s = T(c.machine.r_s),
                 .r_r = T(c.machine.r_r),
                 .l_ls = T(c.machine.l_ls),
                 .l_lr = T(c.machine.l_lr),
                 .l_m = T(c.machine.l_m),
                 .pole_pairs = c.machine.pole_pairs,
                 .inertia = T(c.machine.inertia)};
    const TorqueCapability<T> capability{p};
    const double breakdown = breakdown_torque(c.machine, c.psi);
    const double tolerance = 0.01 * std::min(c.torque, breakdown);
    for (int k = -20; k <= 20; ++k) {
      const double omega_m = c.top_speed * k / 20.0;
      SCOPED_TRACE(std::to_string(c.psi) + " Wb, " + std::to_string(omega_m) + " rad/s");
      const auto reference = [&](double sign) {
        return largest_by_circuit(c.machine, c.psi, c.u_dc / std::sqrt(3.0), std::abs(omega_m), sign,
                                  c.torque);
      };
      const AvailableTorque<T> found = capability.at(T(omega_m), T(c.u_dc));
      if (reference(1.0) < 0.0) {
        EXPECT_FALSE(found.holds_zero_torque);
        continue;
      }
      ASSERT_TRUE(found.holds_zero_torque);
      EXPECT_NEAR(found.motoring, reference(1.0), tolerance);
      EXPECT_NEAR(found.regenerating, reference(-1.0), tolerance);
      EXPECT_LE(double(found.motoring), reference(1.0) + 3.0 * breakdown / slip_steps)
          << "never above what there is";
    }
  }
}

TYPED_TEST(TorqueCapabilityOf, FallsWithTheLinksVoltage) {
  using T = TypeParam;
  const auto capability = this->paper();
  T before = T(151);
  for (const T u_dc : {T(530), T(450), T(440), T(430), T(420), T(400)}) {
    const T now = capability.at(T(100), u_dc).motoring;
    EXPECT_LT(now, before) << u_dc;
    before = now;
  }
  EXPECT_FALSE(capability.at(T(100), T(370)).holds_zero_torque);
  EXPECT_FALSE(capability.at(T(0), T(0)).holds_zero_torque);
  EXPECT_FALSE(capability.at(T(0), T(-530)).holds_zero_torque);
}

TYPED_TEST(TorqueCapabilityOf, IsNothingWhereZeroTorqueCannotBeHeld) {
  using T = TypeParam;
  const auto capability = this->paper();
  for (const T omega_m : {T(140), T(-150), T(170), T(1e6), std::numeric_limits<T>::infinity(),
                          std::numeric_limits<T>::quiet_NaN()}) {
    const AvailableTorque<T> none = capability.at(omega_m, this->link);
    EXPECT_EQ(none.motoring, T(0));
    EXPECT_EQ(none.regenerating, T(0)) << "braking could be produced, but not be released";
    EXPECT_FALSE(none.holds_zero_torque);
  }
  EXPECT_FALSE(capability.at(T(0), std::numeric_limits<T>::quiet_NaN()).holds_zero_torque);
}

TYPED_TEST(TorqueCapabilityOf, ComesBackWithVoltageToSpare) {
  using T = TypeParam;
  TorqueCapability<T> capability{{.voltage_use = T(1), .reentry = T(0.05)}};
  EXPECT_TRUE(capability.step(T(138), this->link).holds_zero_torque);
  EXPECT_FALSE(capability.step(T(140), this->link).holds_zero_torque);
  EXPECT_FALSE(capability.step(T(138), this->link).holds_zero_torque) << "it would be gone again in a moment";
  EXPECT_EQ(capability.step(T(133), this->link).regenerating, T(0));
  EXPECT_TRUE(capability.step(T(131), this->link).holds_zero_torque);
  EXPECT_TRUE(capability.step(T(138), this->link).holds_zero_torque);
  EXPECT_FALSE(capability.step(T(138), T(520)).holds_zero_torque) << "the link's voltage falls";
  EXPECT_FALSE(capability.step(T(138), T(530)).holds_zero_torque);
  EXPECT_TRUE(capability.step(T(138), T(560)).holds_zero_torque);
}

TYPED_TEST(TorqueCapabilityOf, ATypedCurveNarrowsIt) {
  using T = TypeParam;
  const TorqueCapability<T> capability{{.torque = T(100), .base_speed = T(50), .zero_torque_speed = T(90)}};
  const struct {
    T omega_m;
    T motoring;
  } cases[] = {{T(0), T(100)}, {T(49), T(100)}, {T(50), T(100)}, {T(60), T(75)},
               {T(70), T(50)}, {T(90), T(0)},   {T(120), T(0)}};
  for (const auto& x : cases) {
    for (const T sign : {T(-1), T(1)}) {
      EXPECT_NEAR(capability.at(sign * x.omega_m, this->link).motoring, x.motoring, T(1e-4));
      EXPECT_EQ(capability.at(sign * x.omega_m, this->link).regenerating, T(100));
    }
  }
  const TorqueCapability<T> wide{{.base_speed = T(115), .zero_torque_speed = T(180)}};
  EXPECT_FALSE(wide.at(T(150), this->link).holds_zero_torque) << "it cannot widen it";
  const TorqueCapability<T> cut{{.zero_torque_speed = T(80)}};
  EXPECT_EQ(cut.at(T(80), this->link).motoring, T(150));
  EXPECT_EQ(cut.at(T(81), this->link).motoring, T(0));
}

TYPED_TEST(TorqueCapabilityOf, TheDirectionOfRotationDecidesWhichTorqueIsMotoring) {
  using T = TypeParam;
  const TorqueCapability<T> capability{{.base_speed = T(100), .zero_torque_speed = T(120)}};
  const auto range = [&](T omega_m) { return capability.at(omega_m, this->link).range(omega_m); };
  EXPECT_EQ(range(T(110)).lowest, T(-150));
  EXPECT_NEAR(range(T(110)).highest, T(75), T(1e-4));
  EXPECT_NEAR(range(T(-110)).lowest, T(-75), T(1e-4));
  EXPECT_EQ(range(T(-110)).highest, T(150));
  EXPECT_EQ(range(T(0)).lowest, T(-150));
  EXPECT_EQ(range(T(0)).highest, T(150));
}

TYPED_TEST(TorqueCapabilityOf, RefusesParametersThatAreNone) {
  using T = TypeParam;
  using Parameters = typename TorqueCapability<T>::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  const T nan = std::numeric_limits<T>::quiet_NaN();
  for (const T bad : {T(0), T(-1), nan, std::numeric_limits<T>::infinity()}) {
    EXPECT_NE((Parameters{.flux_reference = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.voltage_use = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.torque = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.machine = {.r_s = bad}}.validate()), nullptr);
  }
  for (const T bad : {T(-0.1), T(0.98), nan}) EXPECT_NE((Parameters{.reentry = bad}.validate()), nullptr);
  for (const T bad : {T(0), T(-1), nan}) {
    EXPECT_NE((Parameters{.base_speed = bad, .zero_torque_speed = T(100)}.validate()), nullptr);
    EXPECT_NE((Parameters{.zero_torque_speed = bad}.validate()), nullptr);
  }
  EXPECT_NE((Parameters{.base_speed = T(100)}.validate()), nullptr);
  EXPECT_NE((Parameters{.base_speed = T(100), .zero_torque_speed = T(100)}.validate()), nullptr);
}

}  // namespace
}  // namespace sextant
