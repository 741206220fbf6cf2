#include "sextant/drive/torque_capability.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr double paper_flux = 1.1;
constexpr double paper_link = 530.0;
constexpr double no_limit = 1e9;

/// A machine on a link, with the limits of its drive.
struct Case {
  InductionMachineParameters<> machine;
  double psi;
  double u_dc;
  double torque;
  double current;
  double top_speed;
};

/// Stator current, voltage and torque of the T-equivalent circuit at 1 Wb of stator flux, from its two mesh
/// equations.
struct Circuit {
  double current;
  double voltage;
  double torque;

  Circuit(const InductionMachineParameters<>& m, double omega_r, double omega_slip) {
    using Complex = std::complex<double>;
    const Complex j{0.0, 1.0};
    // 0 = R_r i_r + j ω_slip (L_r i_r + L_m i_s) gives i_r by i_s, and ψ = L_s i_s + L_m i_r the rest.
    const Complex i_r_by_i_s = -j * omega_slip * m.l_m / (m.r_r + j * omega_slip * m.l_r());
    const Complex i_s = 1.0 / (m.l_s() + m.l_m * i_r_by_i_s);
    current = std::abs(i_s);
    voltage = std::abs(m.r_s * i_s + j * (omega_r + omega_slip));
    torque = 1.5 * m.pole_pairs * i_s.imag();
  }
};

/// Slip of the breakdown torque by stepping, up to which the machine is stable. [rad/s]
double breakdown_slip(const InductionMachineParameters<>& m) {
  const double step = 1e-4 * m.l_s() / (m.sigma_l_s() * m.tau_r());
  double slip = step;
  while (Circuit{m, 0.0, slip + step}.torque > Circuit{m, 0.0, slip}.torque) slip += step;
  return slip;
}

/// Largest magnitude of torque of that sign, and the flux at which it is produced, over all slips whose
/// torque is at most `use` of the breakdown torque, each at the largest flux that voltage and reference
/// allow.
struct Largest {
  double torque{};
  double flux{};
};
Largest largest_by_circuit(const Case& c, double omega_m, double sign, double use) {
  constexpr int steps = 5000;
  const double last = breakdown_slip(c.machine);
  const double breakdown = Circuit{c.machine, 0.0, last}.torque;
  Largest found{};
  for (int k = 0; k <= steps; ++k) {
    const Circuit x{c.machine, c.machine.pole_pairs * omega_m, sign * last * k / steps};
    if (sign * x.torque > use * breakdown) break;
    const double flux = std::min(c.psi, c.u_dc / std::sqrt(3.0) / x.voltage);
    const double torque = sign * x.torque * flux * flux;
    if (x.current * flux <= c.current && torque > found.torque) found = {torque, flux};
  }
  found.torque = std::min(found.torque, c.torque);
  return found;
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

InductionMachineParameters<> small_machine() {
  return {.r_s = 25, .r_r = 22, .l_ls = 0.06, .l_lr = 0.06, .l_m = 1.1, .pole_pairs = 2, .inertia = 3e-4};
}

const std::vector<Case>& cases() {
  static const std::vector<Case> all{{{}, paper_flux, paper_link, 150, no_limit, 400},
                                     {{}, paper_flux, 400, 150, no_limit, 400},
                                     {{}, paper_flux, 250, 150, no_limit, 400},
                                     {{}, paper_flux, paper_link, 1000, no_limit, 400},
                                     {{}, paper_flux, paper_link, 150, 45, 400},
                                     {{}, paper_flux, paper_link, 150, 30, 400},
                                     {{}, 0.5, 300, 60, no_limit, 400},
                                     {{}, paper_flux, 60, 150, no_limit, 60},
                                     {large_machine(), 0.9, 560, 1500, 900, 360},
                                     {small_machine(), 0.9, 540, 2, no_limit, 480}};
  return all;
}

template <class T>
typename TorqueCapability<T>::Parameters parameters_of(const Case& c) {
  typename TorqueCapability<T>::Parameters p{
      .flux_reference = T(c.psi), .current_limit = T(c.current), .torque = T(c.torque)};
  p.machine = {.r_s = T(c.machine.r_s),
               .r_r = T(c.machine.r_r),
               .l_ls = T(c.machine.l_ls),
               .l_lr = T(c.machine.l_lr),
               .l_m = T(c.machine.l_m),
               .pole_pairs = c.machine.pole_pairs,
               .inertia = T(c.machine.inertia)};
  return p;
}

/// The share of the flux reference for a torque, settled.
template <class T>
T flux_share(TorqueCapability<T> capability, T omega_m, T u_dc, T torque) {
  constexpr int steps = 400;  // 10 ms of 25 µs
  for (int k = 0; k < steps; ++k) {
    capability.step(omega_m, u_dc, T(1));
    (void)capability.flux_share(torque);
  }
  return capability.flux_share(torque);
}

template <class T>
class TorqueCapabilityOf : public testing::Test {
 protected:
  static constexpr T link = T(paper_link);
  TorqueCapability<T> paper{typename TorqueCapability<T>::Parameters{}};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(TorqueCapabilityOf, Scalars);

TYPED_TEST(TorqueCapabilityOf, AgreesWithTheEquivalentCircuitWithinTwoPercentOverTheWholeSpeedRange) {
  using T = TypeParam;
  for (const Case& c : cases()) {
    const auto p = parameters_of<T>(c);
    ASSERT_EQ(p.validate(), nullptr);
    const TorqueCapability<T> capability{p};
    for (int k = -40; k <= 40; ++k) {
      const double omega_m = c.top_speed * k / 40.0;
      SCOPED_TRACE(std::to_string(c.psi) + " Wb, " + std::to_string(c.u_dc) + " V, " +
                   std::to_string(c.current) + " A, " + std::to_string(omega_m) + " rad/s");
      const AvailableTorque<T> found = capability.at(T(omega_m), T(c.u_dc));
      const double motoring = largest_by_circuit(c, std::abs(omega_m), 1.0, double(p.breakdown_use)).torque;
      const double regenerating =
          largest_by_circuit(c, std::abs(omega_m), -1.0, double(p.breakdown_use)).torque;
      EXPECT_NEAR(found.motoring.torque, motoring, 0.01 * motoring);
      EXPECT_NEAR(found.regenerating.torque, regenerating, 0.01 * regenerating);
    }
  }
}

// At full breakdown_use the only limits are those of the circuit.
TYPED_TEST(TorqueCapabilityOf, MotoringTorqueBeyondBaseSpeedIsLimitedByVoltageAloneAndNotByTheMargin) {
  using T = TypeParam;
  const Case& c = cases().front();
  for (const double omega_m : {160.0, 250.0, 400.0}) {
    const double whole = largest_by_circuit(c, omega_m, 1.0, 1.0).torque;
    EXPECT_NEAR(this->paper.at(T(omega_m), this->link).motoring.torque, whole, 0.01 * whole);
  }
}

TYPED_TEST(TorqueCapabilityOf, TheFluxShareIsThatOfTheCircuitForTheTorque) {
  using T = TypeParam;
  for (const Case& c : cases()) {
    const auto p = parameters_of<T>(c);
    const TorqueCapability<T> capability{p};
    for (const double share_of_speed : {0.1, 0.4, 0.6, 1.0}) {
      const double omega_m = share_of_speed * c.top_speed;
      for (const double sign : {-1.0, 1.0}) {
        const Largest largest = largest_by_circuit(c, omega_m, sign, double(p.breakdown_use));
        // Voltage that the circuit needs for the torque at the flux that the share gives.
        for (const double load : {0.0, 0.3, 0.8}) {
          const double torque = sign * load * largest.torque;
          const double psi = c.psi * double(flux_share<T>(capability, T(omega_m), T(c.u_dc), T(torque)));
          const double breakdown = breakdown_torque(c.machine, psi);
          const double x = sign * relative_slip(load * largest.torque, breakdown);
          const double slip = x * c.machine.l_s() / (c.machine.sigma_l_s() * c.machine.tau_r());
          const double voltage = psi * Circuit{c.machine, c.machine.pole_pairs * omega_m, slip}.voltage;
          const double limit = c.u_dc / std::sqrt(3.0);
          SCOPED_TRACE(std::to_string(omega_m) + " rad/s, " + std::to_string(torque) + " N·m");
          if (psi == c.psi) {
            EXPECT_LE(voltage, 1.001 * limit);
          } else {
            EXPECT_NEAR(voltage, limit, 0.005 * limit);
          }
        }
      }
    }
  }
}

TYPED_TEST(TorqueCapabilityOf, TheFluxShareIsExactlyOneWhereTheVoltageSuffices) {
  using T = TypeParam;
  for (const T omega_m : {T(-100), T(0), T(3), T(100)}) {
    for (const T torque : {T(-150), T(-15), T(0), T(130)}) {
      TorqueCapability<T> capability{typename TorqueCapability<T>::Parameters{}};
      for (int k = 0; k < 100; ++k) {
        capability.step(omega_m, this->link, T(1));
        EXPECT_EQ(capability.flux_share(torque), T(1));
      }
    }
  }
}

TYPED_TEST(TorqueCapabilityOf, ZeroTorqueIsAvailableAtAnySpeedAtItsFlux) {
  using T = TypeParam;
  for (const T omega_m : {T(140), T(-200), T(400), T(1000)}) {
    const AvailableTorque<T> found = this->paper.at(omega_m, this->link);
    EXPECT_GT(found.motoring.torque, T(0));
    EXPECT_GT(found.regenerating.torque, T(0));
    const double psi = paper_flux * double(flux_share<T>(this->paper, omega_m, this->link, T(0)));
    EXPECT_NEAR(psi * Circuit(InductionMachineParameters<>{}, 2.0 * double(omega_m), 0.0).voltage,
                paper_link / std::sqrt(3.0), 0.5);
  }
}

TYPED_TEST(TorqueCapabilityOf, NamesTheCauseOfEachLimit) {
  using T = TypeParam;
  EXPECT_EQ(this->paper.at(T(100), this->link).motoring.cause, DeratingCause::none);
  EXPECT_EQ(this->paper.at(T(200), this->link).motoring.cause, DeratingCause::voltage_limit);
  EXPECT_EQ(this->paper.at(T(200), this->link).regenerating.cause, DeratingCause::none);
  EXPECT_EQ(this->paper.at(T(350), this->link).regenerating.cause, DeratingCause::voltage_limit);
  const TorqueCapability<T> weak{{.current_limit = T(45)}};
  EXPECT_EQ(weak.at(T(50), this->link).motoring.cause, DeratingCause::current_limit);
  EXPECT_EQ(weak.at(T(160), this->link).motoring.cause, DeratingCause::current_limit);
  EXPECT_EQ(weak.at(T(400), this->link).motoring.cause, DeratingCause::voltage_limit);
  EXPECT_EQ(weak.at(T(400), this->link).regenerating.cause, DeratingCause::current_limit);
}

TYPED_TEST(TorqueCapabilityOf, FallsWithTheLinksVoltageAndItsUsableShare) {
  using T = TypeParam;
  T before = T(151);
  for (const T u_dc : {T(530), T(400), T(390), T(380), T(300), T(100)}) {
    const T now = this->paper.at(T(100), u_dc).motoring.torque;
    EXPECT_LT(now, before) << u_dc;
    before = now;
  }
  TorqueCapability<T> reduced = this->paper;
  for (int k = 0; k < reduced.search_steps; ++k) reduced.step(T(300), this->link, T(0.64));
  EXPECT_EQ(reduced.available().motoring.torque, this->paper.at(T(300), T(0.8) * this->link).motoring.torque);
}

TYPED_TEST(TorqueCapabilityOf, IsNothingWithoutLinkVoltageOrSpeed) {
  using T = TypeParam;
  const T nan = std::numeric_limits<T>::quiet_NaN();
  const T infinity = std::numeric_limits<T>::infinity();
  const struct {
    T omega_m;
    T u_dc;
  } unusable[] = {{T(0), T(0)},  {T(100), T(0)}, {T(0), T(-530)},   {T(0), nan},
                  {nan, T(530)}, {nan, nan},     {infinity, T(530)}};
  for (const auto& x : unusable) {
    TorqueCapability<T> capability = this->paper;
    for (int k = 0; k < 3; ++k) {
      capability.step(x.omega_m, x.u_dc, T(1));
      const T share = capability.flux_share(T(0));
      EXPECT_GT(share, T(0));
      EXPECT_LE(share, T(1));
    }
    EXPECT_EQ(capability.available().motoring.torque, T(0));
    EXPECT_EQ(capability.available().regenerating.torque, T(0));
    EXPECT_EQ(capability.available().motoring.cause, DeratingCause::voltage_limit);
    // Nothing of it stays.
    EXPECT_EQ(flux_share<T>(capability, T(50), this->link, T(15)), T(1));
    EXPECT_EQ(capability.at(T(50), this->link).motoring.torque, T(150));
  }
}

TYPED_TEST(TorqueCapabilityOf, BothSidesFollowSpeedAndLinkWithinTwoSearches) {
  using T = TypeParam;
  TorqueCapability<T> capability = this->paper;
  for (const T omega_m : {T(50), T(300), T(-350), T(120), T(310)}) {
    // The one in progress began with the conditions before.
    for (int k = 0; k < 2 * capability.search_steps; ++k) capability.step(omega_m, this->link, T(1));
    const AvailableTorque<T> now = capability.at(omega_m, this->link);
    EXPECT_NEAR(capability.available().motoring.torque, now.motoring.torque, T(0.05));
    EXPECT_NEAR(capability.available().regenerating.torque, now.regenerating.torque, T(0.05));
  }
}

TYPED_TEST(TorqueCapabilityOf, ATypedCurveNarrowsIt) {
  using T = TypeParam;
  const TorqueCapability<T> capability{{.torque = T(100), .base_speed = T(50), .zero_torque_speed = T(90)}};
  const struct {
    T omega_m;
    T motoring;
  } points[] = {{T(0), T(100)}, {T(49), T(100)}, {T(50), T(100)}, {T(60), T(75)},
                {T(70), T(50)}, {T(90), T(0)},   {T(120), T(0)}};
  for (const auto& x : points) {
    for (const T sign : {T(-1), T(1)}) {
      EXPECT_NEAR(capability.at(sign * x.omega_m, this->link).motoring.torque, x.motoring, T(1e-4));
      EXPECT_EQ(capability.at(sign * x.omega_m, this->link).regenerating.torque, T(100));
    }
  }
  EXPECT_EQ(capability.at(T(60), this->link).motoring.cause, DeratingCause::none);
  const TorqueCapability<T> wide{{.base_speed = T(300), .zero_torque_speed = T(900)}};
  EXPECT_EQ(wide.at(T(250), this->link).motoring.torque, this->paper.at(T(250), this->link).motoring.torque)
      << "it cannot widen it";
  const TorqueCapability<T> cut{{.zero_torque_speed = T(80)}};
  EXPECT_EQ(cut.at(T(80), this->link).motoring.torque, T(150));
  EXPECT_EQ(cut.at(T(81), this->link).motoring.torque, T(0));
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
  const AvailableTorque<T> available{{T(1), DeratingCause::none}, {T(2), DeratingCause::none}};
  EXPECT_EQ(available.side(T(5), T(10)).torque, T(1));
  EXPECT_EQ(available.side(T(-5), T(-10)).torque, T(1));
  EXPECT_EQ(available.side(T(5), T(-10)).torque, T(2));
  EXPECT_EQ(available.side(T(-5), T(10)).torque, T(2));
}

TYPED_TEST(TorqueCapabilityOf, RefusesParametersThatAreNone) {
  using T = TypeParam;
  using Parameters = typename TorqueCapability<T>::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  const T nan = std::numeric_limits<T>::quiet_NaN();
  for (const T bad : {T(0), T(-1), nan, std::numeric_limits<T>::infinity()}) {
    EXPECT_NE((Parameters{.flux_reference = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.voltage_use = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.breakdown_use = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.current_limit = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.torque = bad}.validate()), nullptr);
    EXPECT_NE((Parameters{.machine = {.r_s = bad}}.validate()), nullptr);
  }
  EXPECT_EQ((Parameters{.voltage_use = T(1.1026)}.validate()), nullptr) << "2 sqrt(3)/pi is six-step";
  EXPECT_NE((Parameters{.voltage_use = T(1.1027)}.validate()), nullptr);
  EXPECT_NE((Parameters{.current_limit = T(19)}.validate()), nullptr) << "1.5 times 12.9 A";
  EXPECT_EQ((Parameters{.current_limit = T(20)}.validate()), nullptr);
  for (const T bad : {T(0), T(-1), nan}) {
    EXPECT_NE((Parameters{.base_speed = bad, .zero_torque_speed = T(100)}.validate()), nullptr);
    EXPECT_NE((Parameters{.zero_torque_speed = bad}.validate()), nullptr);
  }
  EXPECT_NE((Parameters{.base_speed = T(100)}.validate()), nullptr);
  EXPECT_NE((Parameters{.base_speed = T(100), .zero_torque_speed = T(100)}.validate()), nullptr);
}

// A search that began with the old limits is not to end with them.
TEST(TorqueCapability, LimitsThatAreTakenLowerCountAtOnceAndForGood) {
  TorqueCapability<>::Parameters p;
  for (const double omega_m : {140.0, 160.0, -200.0}) {
    for (int offset = 0; offset < 2 * TorqueCapability<>::search_steps; ++offset) {
      TorqueCapability<> running{p};
      for (int k = 0; k < 100 + offset; ++k) running.step(omega_m, paper_link, 1.0);
      TorqueCapability<>::Parameters lower = p;
      lower.breakdown_use = 0.15;
      const TorqueCapability<> taken{lower};
      running.take_parameters(taken);
      TorqueCapability<> steady{lower};
      for (int k = 0; k < 100; ++k) steady.step(omega_m, paper_link, 1.0);
      for (int k = 0; k < 50; ++k) {
        running.step(omega_m, paper_link, 1.0);
        // With the whole flux the share of the breakdown torque is the limit at most.
        const double most = std::max(breakdown_torque(lower.machine, lower.flux_reference) * 0.15,
                                     steady.available().motoring.torque);
        ASSERT_LE(running.available().motoring.torque, most * (1 + 1e-9))
            << omega_m << ", " << offset << ", " << k;
      }
      EXPECT_NEAR(running.available().motoring.torque, steady.available().motoring.torque,
                  1e-3 * steady.available().motoring.torque);
    }
  }
}

}  // namespace
}  // namespace sextant
