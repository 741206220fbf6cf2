// The plant takes its machine as a class: here one with a saturation of its own.
#include "sextant/plant/plant_machine.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/exact_integrator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"

namespace sextant {
namespace {

constexpr double l_m = 0.08;
constexpr double l_lr = 0.005;

/// Γ-equivalent circuit, all leakage on the rotor's side, with the magnetising current
///   i_m = ψ_s/L_m (1 + (|ψ_s|/ψ_knee)⁴).
/// Source: G. R. Slemon, "Modelling of induction machines for electric drives", IEEE Trans. Ind. Appl. 25
/// (1989) 1126–1131.
class SaturatingMachine : public InductionMachine<double> {
 public:
  SaturatingMachine(const InductionMachineParameters<>& parameters, double knee) noexcept
      : InductionMachine{parameters}, knee_{knee} {}
  explicit SaturatingMachine(const InductionMachineParameters<>& parameters) noexcept
      : SaturatingMachine{parameters, 1.0} {}

  [[nodiscard]] bool is_linear() const noexcept { return false; }

  [[nodiscard]] SpaceVector<> stator_current(SpaceVector<> psi_s, SpaceVector<> psi_r) const noexcept {
    return InductionMachine::stator_current(psi_s, psi_r) + saturation(magnitude(psi_s)) * psi_s;
  }

  /// By fixed-point iteration.
  [[nodiscard]] SpaceVector<> stator_flux(SpaceVector<> i_s, SpaceVector<> psi_r) const noexcept {
    SpaceVector<> psi = InductionMachine::stator_flux(i_s, psi_r);
    const SpaceVector<> source = i_s + (1.0 / l_lr) * psi_r;
    for (int n = 0; n < 30; ++n) psi = (1.0 / (1.0 / l_lr + 1.0 / l_m + saturation(magnitude(psi)))) * source;
    return psi;
  }

 private:
  /// Magnetising current per flux beyond the linear one. [A/Wb]
  [[nodiscard]] double saturation(double psi) const noexcept { return std::pow(psi / knee_, 4) / l_m; }

  double knee_;
};

static_assert(PlantMachine<InductionMachine<double>, double>);
static_assert(PlantMachine<InductionMachine<float>, float>);
static_assert(PlantMachine<SaturatingMachine, double>);

using SaturatingPlant = DrivePlant<double, NoAppendedSystem<double>, SaturatingMachine>;
using LinearPlant = DrivePlant<double>;

DrivePlantParameters<> gamma_machine() {
  DrivePlantParameters<> p;
  p.machine.l_ls = 0.0;
  p.machine.l_lr = l_lr;
  p.machine.l_m = l_m;
  return p;
}

TEST(PlantMachine, WithoutSaturationItIsTheLinearOne) {
  LinearPlant linear{gamma_machine()};
  SaturatingPlant saturating{gamma_machine(), {}, SaturatingMachine{gamma_machine().machine, 1e9}};
  FixedStepIntegrator<LinearPlant> linear_integrator;
  FixedStepIntegrator<SaturatingPlant> integrator;
  for (const SwitchState state : {switch_states[1], switch_states[2], gates_off, switch_states[3]}) {
    linear.set_inputs({state, 530, 5, false, 0});
    saturating.set_inputs({state, 530, 5, false, 0});
    ASSERT_TRUE(linear_integrator.advance(linear, 5'000'000));
    ASSERT_TRUE(integrator.advance(saturating, 5'000'000));
    EXPECT_LT((linear.state() - saturating.state()).norm(), 1e-9);
  }
}

/// At standstill the current ends at u/R_s and the flux where the saturation curve has it.
template <class Integrator>
void expect_flux_on_the_curve(Integrator&& integrator) {
  constexpr double u_s = 10;  // [V]
  constexpr double knee = 1.2;
  SaturatingPlant plant{gamma_machine(), {}, SaturatingMachine{gamma_machine().machine, knee}};
  plant.set_inputs({switch_states[1], 1.5 * u_s, 0, true, 0});
  ASSERT_TRUE(integrator.advance(plant, 4'000'000'000));
  const double current = u_s / gamma_machine().machine.r_s;
  EXPECT_NEAR(plant.i_s().alpha, current, 1e-4 * current);
  double psi = 1.0;  // Newton's method on the curve
  for (int n = 0; n < 50; ++n) {
    const double rise = std::pow(psi / knee, 4);
    psi -= (psi / l_m * (1 + rise) - current) / ((1 + 5 * rise) / l_m);
  }
  EXPECT_NEAR(plant.psi_s().alpha, psi, 1e-4 * psi);
  EXPECT_LT(psi, 0.8 * l_m * current) << "the machine is far in saturation";
  EXPECT_NEAR(plant.i_abc().a, current, 1e-4 * current);
}

TEST(PlantMachine, TheExactIntegratorMovesLinearOnesAlone) {
  const auto advances = [](auto plant) {
    ExactIntegrator<decltype(plant)> integrator;
    plant.set_inputs({switch_states[1], 530, 0, false, 0});
    const auto before = plant.state();
    const bool good = integrator.advance(plant, 25'000);
    EXPECT_EQ(plant.state() == before, !good);
    return good;
  };
  DrivePlantParameters<> saturating;
  saturating.saturation.knee = 1.2;
  EXPECT_TRUE(advances(LinearPlant{gamma_machine()}));
  EXPECT_FALSE(advances(LinearPlant{saturating}));
  EXPECT_FALSE(advances(SaturatingPlant{gamma_machine()}));
}

TEST(PlantMachine, ASaturatingOneReachesTheFluxOfItsCurve) {
  expect_flux_on_the_curve(FixedStepIntegrator<SaturatingPlant>{});
  expect_flux_on_the_curve(CvodeIntegrator<SaturatingPlant>{{}});
}

}  // namespace
}  // namespace sextant
