// The plant takes its machine as a class: here one with a saturation of its own.
#include "sextant/plant/plant_machine.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/energy_meter.hpp"
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
  explicit SaturatingMachine(const DrivePlantParameters<>& plant) noexcept
      : SaturatingMachine{plant.machine, 1.0} {}

  [[nodiscard]] bool is_linear() const noexcept { return false; }

  [[nodiscard]] MachineEvaluation<> evaluate(const FluxPair<>& psi, SpaceVector<> u_s,
                                             double omega_m) const noexcept {
    const double added = saturation(magnitude(psi.s));
    MachineEvaluation<> e = InductionMachine::evaluate(psi, u_s, omega_m);
    e.i_s = e.i_s + added * psi.s;
    e.dpsi.s = u_s - stator_resistance() * e.i_s;
    e.stator_loss = 1.5 * stator_resistance() * dot(e.i_s, e.i_s);
    e.field_energy += 0.25 * added * dot(psi.s, psi.s);  // 3/2 ∫ added psi dpsi
    return e;
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

/// Magnets of 0.5 Wb on the rotor, the same inductance in each direction: no rotor current, no Jacobian of
/// its own, and no equations of a linear machine.
class MagnetMachine {
 public:
  [[nodiscard]] MachineEvaluation<> evaluate(const FluxPair<>& psi, SpaceVector<> u_s,
                                             double omega_m) const noexcept {
    MachineEvaluation<> e;
    e.i_s = (1.0 / l_s) * (psi.s - psi.r);
    e.tau_e = 1.5 * pairs * cross(psi.s, e.i_s);
    e.stator_loss = 1.5 * r_s * dot(e.i_s, e.i_s);
    e.dpsi = {u_s - r_s * e.i_s, (pairs * omega_m) * rotate_90(psi.r)};
    e.field_energy = 0.75 * l_s * dot(e.i_s, e.i_s);
    return e;
  }
  [[nodiscard]] BackEmf<> emf(const FluxPair<>&, const MachineEvaluation<>& e) const noexcept {
    return e.dpsi.r;
  }
  [[nodiscard]] SpaceVector<> stator_flux(SpaceVector<> i_s, SpaceVector<> psi_r) const noexcept {
    return l_s * i_s + psi_r;
  }
  [[nodiscard]] InverseInductance<> inverse_inductance(SpaceVector<>, SpaceVector<>) const noexcept {
    return {1.0 / l_s, 0.0, {}};
  }
  [[nodiscard]] double damping(SpaceVector<>, SpaceVector<>) const noexcept { return r_s / l_s; }
  [[nodiscard]] double angle_gain(SpaceVector<>, SpaceVector<>) const noexcept {
    return 1.5 * pairs * pairs / l_s;
  }
  [[nodiscard]] double largest_inductance() const noexcept { return l_s; }
  [[nodiscard]] double stator_resistance() const noexcept { return r_s; }
  [[nodiscard]] double pole_pairs() const noexcept { return pairs; }

 private:
  static constexpr double l_s = 0.04, r_s = 3.0, pairs = 3.0;
};

static_assert(PlantMachine<MagnetMachine, double> && !LinearEquations<MagnetMachine, double>);
static_assert(!DifferentiatedMachine<MagnetMachine, double> && !HeatedMachine<MagnetMachine, double>);

using MagnetPlant = DrivePlant<double, EnergyMeter<double>, MagnetMachine>;

MagnetPlant magnets_at_speed() {
  DrivePlantParameters<> p;
  p.machine.inertia = 0.015;
  p.initial = {.speed = 120.0, .rotor_flux = 0.5};
  return {p, {}, MagnetMachine{}};
}

/// What the meter of a plant leaves over, driven and with the gates off, by what has gone into copper.
template <class Integrator>
double unaccounted(MagnetPlant& plant, Integrator&& integrator) {
  using Meter = EnergyMeter<double>;
  const double stored = plant.magnetic_energy();
  for (const SwitchState state : {switch_states[1], switch_states[3], switch_states[0], gates_off}) {
    plant.set_inputs({state, 300, 2, false, 0});
    EXPECT_TRUE(integrator.advance(plant, 2'000'000));
  }
  const auto meter = MagnetPlant::states_of<Meter>(plant.state());
  const double copper = meter[Meter::stator_copper];
  EXPECT_GT(copper, 1e-2);
  EXPECT_EQ(meter[Meter::rotor_copper], 0.0);
  EXPECT_EQ(meter[Meter::iron], 0.0);
  const double into = copper + meter[Meter::mechanical] + plant.magnetic_energy() - stored;
  return std::abs(meter[Meter::dc_link] - into) / copper;
}

TEST(PlantMachine, TheEnergiesOfAnotherKindBalanceByItsEvaluation) {
  MagnetPlant fixed = magnets_at_speed(), adams = magnets_at_speed(), bdf = magnets_at_speed();
  EXPECT_LT(unaccounted(fixed, FixedStepIntegrator<MagnetPlant>{}), 1e-5);
  EXPECT_LT(unaccounted(adams, CvodeIntegrator<MagnetPlant>{}), 1e-4);
  CvodeParameters newton;
  newton.method = CvodeMethod::bdf_newton;
  EXPECT_LT(unaccounted(bdf, CvodeIntegrator<MagnetPlant>{newton}), 1e-4);
  EXPECT_NEAR(magnitude(fixed.psi_r()), 0.5, 1e-6) << "the magnets keep their flux";
  EXPECT_LT((fixed.state() - adams.state()).norm(), 1e-3);
  EXPECT_LT((bdf.state() - adams.state()).norm(), 1e-3);
}

TEST(PlantMachine, TheQuantitiesOfThePlantAreThoseOfItsEvaluation) {
  MagnetPlant plant = magnets_at_speed();
  plant.set_inputs({switch_states[2], 300, 2, false, 0});
  ASSERT_TRUE(FixedStepIntegrator<MagnetPlant>{}.advance(plant, 1'000'000));
  const FluxPair<> psi{plant.psi_s(), plant.psi_r()};
  const MachineEvaluation<> e = MagnetMachine{}.evaluate(psi, plant.u_s(), plant.omega_m());
  const PlantQuantities<> q = plant.quantities_at(plant.state());
  EXPECT_GT(magnitude(e.i_s), 1.0);
  EXPECT_EQ(plant.i_s(), e.i_s);
  EXPECT_EQ(q.i_s, e.i_s);
  EXPECT_EQ(plant.tau_e(), e.tau_e);
  EXPECT_EQ(q.tau_e, e.tau_e);
  EXPECT_EQ(q.stator_loss, e.stator_loss);
  EXPECT_EQ(plant.magnetic_energy(), e.field_energy);
  MagnetPlant::State dx;
  plant.derivative(plant.state(), dx);
  EXPECT_EQ(MagnetPlant::fluxes(dx).s, e.dpsi.s);
  EXPECT_EQ(MagnetPlant::fluxes(dx).r, e.dpsi.r);
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
