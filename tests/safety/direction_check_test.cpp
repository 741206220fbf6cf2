#include "sextant/safety/direction_check.hpp"

#include <cmath>
#include <complex>

#include <gtest/gtest.h>

namespace sextant {
namespace {

using Complex = std::complex<double>;

/// A machine that is fed with a current of constant magnitude and frequency from no flux on, in closed form:
///   ψ_r = L_m i (1 − exp((−1/τ_r + j (p ω_m − ω_e)) t))/(1 + j (ω_e − p ω_m) τ_r)   in the frame of i,
///   ∫u dt = R_s ∫i dt + k_r Δψ_r + σL_s Δi.
template <class T>
class DirectionCheckOf : public testing::Test {
 protected:
  using Parameters = typename DirectionCheck<T>::Parameters;
  static constexpr double dt = 50e-6;
  static constexpr double u_dc = 311.0;

  [[nodiscard]] Complex psi_r(double t) const {
    const double slip = omega_e - machine.pole_pairs * omega_m;
    const Complex rate{-1.0 / rotor_tau, -slip};
    return machine.l_m * current / Complex{1.0, slip * rotor_tau} * (1.0 - std::exp(rate * t)) *
           std::polar(1.0, omega_e * t);
  }
  [[nodiscard]] Complex i_s(double t) const { return std::polar(current, omega_e * t); }

  /// `seconds` from the start of a new check; the shaft turns at omega_m, `read` is measured. True where the
  /// reading was reversed at any time.
  [[nodiscard]] bool is_reversed(double read, double seconds) {
    DirectionCheck<T> check{{.machine = machine_of_check(), .current_noise = T(0.01), .slowest = T(0.2)}};
    for (int n = 0; n < 2000; ++n) check.step_without_voltage({}, T(read), T(dt));  // gates off
    bool found = false;
    for (long n = 0; n < std::lround(seconds / dt); ++n) {
      const double t0 = double(n) * dt;
      const double t1 = t0 + dt;
      const Complex i_mean = i_s(t0 + dt / 2);
      const Complex across = Complex{0.0, voltage_error} * i_mean / std::abs(i_mean);
      const Complex volt_seconds = emf_share * machine.k_r() * (psi_r(t1) - psi_r(t0)) +
                                   machine.sigma_l_s() * (i_s(t1) - i_s(t0)) +
                                   (machine.r_s * r_s_factor * i_mean + across) * dt;
      check.step(phases(i_s(t1)), phases(volt_seconds), T(u_dc), T(read), T(dt));
      found = found || check.is_reversed();
    }
    return found;
  }

  [[nodiscard]] InductionMachineParameters<T> machine_of_check() const {
    return {T(machine.r_s),  T(machine.r_r), T(machine.l_ls),
            T(machine.l_lr), T(machine.l_m), machine.pole_pairs};
  }
  static ThreePhase<T> phases(Complex x) {
    const ThreePhase<double> p = inverse_clarke(SpaceVector<double>{x.real(), x.imag()});
    return {T(p.a), T(p.b), T(p.c)};
  }

  InductionMachineParameters<double> machine{0.467, 0.380, 0.0033, 0.0033, 0.039674, 4, 0.2066};
  double rotor_tau{machine.tau_r()};  ///< of the true machine [s]
  double current{14.0};               ///< [A]
  double omega_e{0.0};                ///< of the current [rad/s]
  double omega_m{2.0};                ///< of the shaft [rad/s]
  double r_s_factor{1.0};             ///< of the true stator resistance [-]
  double voltage_error{0.0};          ///< across the current [V]
  double emf_share{1.0};              ///< of the voltage of the flux that there is [-]
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(DirectionCheckOf, Scalars);

TYPED_TEST(DirectionCheckOf, ADirectCurrentThatMagnetisesShowsTheDirection) {
  for (const double omega : {-20.0, -2.0, 2.0, 20.0}) {
    SCOPED_TRACE(omega);
    this->omega_m = omega;
    EXPECT_FALSE(this->is_reversed(omega, 0.5));
    EXPECT_TRUE(this->is_reversed(-omega, 0.5));
  }
}

TYPED_TEST(DirectionCheckOf, ATurningFieldShowsItWithAndWithoutSlip) {
  for (const double omega : {-60.0, -8.0, 8.0, 60.0}) {
    for (const double slip : {-6.0, 0.0, 6.0}) {
      SCOPED_TRACE(testing::Message() << omega << ' ' << slip);
      this->omega_m = omega;
      this->omega_e = 4.0 * omega + slip;
      EXPECT_FALSE(this->is_reversed(omega, 0.5));
      EXPECT_TRUE(this->is_reversed(-omega, 0.5));
    }
  }
}

TYPED_TEST(DirectionCheckOf, StatorResistanceDoesNotMatter) {
  for (const double factor : {0.5, 1.5}) {
    this->r_s_factor = factor;
    EXPECT_FALSE(this->is_reversed(2.0, 0.5)) << factor;
    EXPECT_TRUE(this->is_reversed(-2.0, 0.5)) << factor;
  }
}

TYPED_TEST(DirectionCheckOf, ErrorsOfTheModelAreNoReversal) {
  for (const double omega : {-60.0, -2.0, -0.3, 0.3, 2.0, 60.0}) {
    for (const double slip : {-16.0, 0.0, 16.0}) {
      for (const double factor : {0.67, 1.0, 1.5}) {
        for (const double error : {-0.3, 0.3}) {
          SCOPED_TRACE(testing::Message() << omega << ' ' << slip << ' ' << factor << ' ' << error);
          this->omega_m = omega;
          this->omega_e = 4.0 * omega + slip;
          this->rotor_tau = factor * this->machine.tau_r();
          this->voltage_error = error;
          EXPECT_FALSE(this->is_reversed(omega, 0.3));
        }
      }
    }
  }
}

TYPED_TEST(DirectionCheckOf, TooSlowIsNotDecided) {
  this->omega_m = 0.1;
  EXPECT_FALSE(this->is_reversed(-0.1, 0.5)) << "below `slowest`";
  this->omega_m = 0.3;
  this->omega_e = 0.3 * 4.0;
  EXPECT_FALSE(this->is_reversed(-0.3, 0.5)) << "2 p omega tau_r = 0.27 in a turning field";
}

TYPED_TEST(DirectionCheckOf, AVoltageThatFitsNeitherDirectionIsNoReversal) {
  for (const double share : {-2.0, 2.0, 3.0}) {
    this->emf_share = share;
    EXPECT_FALSE(this->is_reversed(2.0, 0.5)) << share;
    EXPECT_FALSE(this->is_reversed(-2.0, 0.5)) << share;
  }
}

}  // namespace
}  // namespace sextant
