#include "sextant/control/switching_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sextant/core/space_vector.hpp"
#include "sextant/core/two_level_inverter.hpp"

namespace sextant {
namespace {

/// Signs that a voltage vector gives to |ψ_s| and T_e at R_s = 0.
struct Effect {
  int flux;
  int torque;
};

int sign(double x) {
  return x > 1e-9 ? 1 : (x < -1e-9 ? -1 : 0);
}

double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

// d|ψ_s|/dt = u_s · ψ_s/|ψ_s|. T_e ∝ ψ_r × ψ_s, and ψ_r, behind its time constant, stands still while the
// voltage acts, so dT_e/dt ∝ ψ_r × u_s.
Effect effect(SwitchState state, double flux_degrees, double load_angle_degrees) {
  const SpaceVector<double> u_s = stator_voltage(state, 530.0);
  const auto psi_s = polar(1.1, radians(flux_degrees));
  const auto psi_r = polar(1.06, radians(flux_degrees - load_angle_degrees));
  return {sign(dot(u_s, psi_s)), sign(cross(psi_r, u_s))};
}

class SwitchingTable : public testing::TestWithParam<int> {
 protected:
  [[nodiscard]] static std::uint8_t sector() { return std::uint8_t(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(Sector, SwitchingTable, testing::Range(1, 7));

TEST_P(SwitchingTable, CentredSectorsMoveFluxAndTorqueAsDemandedEverywhere) {
  const double centre = 60.0 * (sector() - 1);
  for (const double offset : {-29.0, 0.0, 29.0}) {
    for (const double load_angle : {-10.0, 0.0, 10.0}) {
      for (const int torque_demand : {-1, 1}) {
        for (const bool raise_flux : {false, true}) {
          const SwitchState state = select_state(sector(), raise_flux, torque_demand, gates_off);
          const Effect got = effect(state, centre + offset, load_angle);
          SCOPED_TRACE(testing::Message() << "offset " << offset << "°, load angle " << load_angle << "°");
          EXPECT_EQ(got.flux, raise_flux ? 1 : -1);
          EXPECT_EQ(got.torque, torque_demand);
        }
      }
    }
  }
}

// With sectors that start on the vectors the torque still goes the right way, but of the four demands two
// move the flux the wrong way over half of the sector: the reason why the flux collapses in reverse.
TEST_P(SwitchingTable, SectorsThatStartOnTheVectorsLoseTheFluxInHalfOfEach) {
  const double start = 60.0 * (sector() - 1);
  for (const double offset : {1.0, 29.0, 31.0, 59.0}) {
    for (const int torque_demand : {-1, 1}) {
      for (const bool raise_flux : {false, true}) {
        const SwitchState state = select_state(sector(), raise_flux, torque_demand, gates_off);
        const Effect got = effect(state, start + offset, 0);
        SCOPED_TRACE(testing::Message() << "offset " << offset << "°");
        EXPECT_EQ(got.torque, torque_demand);
        const bool flux_is_right = (got.flux > 0) == raise_flux;
        const bool demands_are_opposed = raise_flux == (torque_demand < 0);
        EXPECT_EQ(flux_is_right, !demands_are_opposed || offset < 30);
      }
    }
  }
}

TEST_P(SwitchingTable, HoldingTorqueTakesTheZeroVectorOfFewestCommutations) {
  constexpr std::array legs{LegState::low, LegState::high, LegState::off};
  for (const LegState a : legs) {
    for (const LegState b : legs) {
      for (const LegState c : legs) {
        const SwitchState present{a, b, c};
        const int fewest =
            std::min(commutations(present, switch_states[0]), commutations(present, switch_states[7]));
        for (const bool raise_flux : {false, true}) {
          const SwitchState chosen = select_state(sector(), raise_flux, 0, present);
          EXPECT_EQ(magnitude(stator_voltage(chosen, 1.0)), 0.0);
          EXPECT_EQ(commutations(present, chosen), fewest);
        }
      }
    }
  }
}

TEST_P(SwitchingTable, FluxPriorityRaisesTheFluxWhereTheTorqueHoldsAndChangesNothingElse) {
  const double centre = 60.0 * (sector() - 1);
  for (const SwitchState present : {switch_states[0], switch_states[5], gates_off}) {
    for (const bool raise_flux : {false, true}) {
      const SwitchState radial = select_state(sector(), raise_flux, 0, present, true);
      for (const double offset : {-30.0, 0.0, 30.0}) {
        const auto along = polar(1.0, radians(centre + offset));
        EXPECT_GE(dot(stator_voltage(radial, 530.0), along), 530 / std::sqrt(3.0) - 1e-9);
      }
      for (const int torque_demand : {-1, 0, 1}) {
        const SwitchState plain = select_state(sector(), raise_flux, torque_demand, present);
        EXPECT_EQ(select_state(sector(), raise_flux, torque_demand, present, false), plain);
        if (torque_demand == 0) continue;
        EXPECT_EQ(select_state(sector(), raise_flux, torque_demand, present, true), plain);
      }
    }
  }
}

// What follows from it: a torque cycle (active vector, zero vector, the same again) commutates one leg.
TEST_P(SwitchingTable, FromAnActiveVectorTheZeroVectorIsOneCommutationAway) {
  for (unsigned n = 1; n <= 6; ++n) {
    const SwitchState active = switch_states[n];
    EXPECT_EQ(commutations(active, select_state(sector(), true, 0, active)), 1);
  }
}

TEST(SwitchingTableData, IsUsableInConstantExpressions) {
  static_assert(is_driven(select_state(1, true, 1, gates_off)));
}

}  // namespace
}  // namespace sextant
