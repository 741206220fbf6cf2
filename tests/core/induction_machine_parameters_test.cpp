#include "sextant/core/induction_machine_parameters.hpp"

#include <limits>
#include <numbers>

#include <gtest/gtest.h>

namespace sextant {
namespace {

TEST(InductionMachineParameters, DefaultsAreThePapersTable2At50Hz) {
  const InductionMachineParameters<double> machine;
  const double omega = 2 * std::numbers::pi * 50;
  EXPECT_NEAR(omega * machine.l_ls, 0.754, 1e-6);
  EXPECT_NEAR(omega * machine.l_lr, 0.754, 1e-6);
  EXPECT_NEAR(omega * machine.l_m, 26.13, 1e-3);
  EXPECT_EQ(machine.validate(), nullptr);
}

TEST(InductionMachineParameters, DerivedQuantitiesSatisfyTheFluxEquations) {
  // ψ_s = L_s i_s + L_m i_r and ψ_r = L_m i_s + L_r i_r must equal ψ_s = k_r ψ_r + σL_s i_s for any currents.
  const InductionMachineParameters<double> m;
  const double i_s = 7.5;
  const double i_r = -3.25;
  const double psi_s = m.l_s() * i_s + m.l_m * i_r;
  const double psi_r = m.l_m * i_s + m.l_r() * i_r;
  EXPECT_NEAR(m.k_r() * psi_r + m.sigma_l_s() * i_s, psi_s, 1e-14);
  EXPECT_NEAR(m.tau_r() * m.r_r, m.l_r(), 1e-15);
}

TEST(InductionMachineParameters, RefusesEveryValueThatMakesNoMachine) {
  using Parameters = InductionMachineParameters<double>;
  constexpr double Parameters::* members[] = {&Parameters::r_s,  &Parameters::r_r, &Parameters::l_ls,
                                              &Parameters::l_lr, &Parameters::l_m, &Parameters::inertia};
  for (const auto member : members) {
    for (const double bad :
         {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      Parameters machine;
      machine.*member = bad;
      EXPECT_NE(machine.validate(), nullptr) << bad;
    }
  }
  Parameters machine;
  machine.pole_pairs = 0;
  EXPECT_NE(machine.validate(), nullptr);
}

}  // namespace
}  // namespace sextant
