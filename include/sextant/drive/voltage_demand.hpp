#pragma once

#include "sextant/core/steady_state.hpp"

namespace sextant {

/// The stator voltage of a machine in steady state, by relative slip x (`steady_state`) at one speed. With
/// a = R_s/L_s, ω_σ = 1/(σ τ_r), b = ω_σ + a/σ and the electrical speed ω_r,
///   |u_s|² (1 + x²)/ψ² = N(x) = (a − ω_r x − ω_σ x²)² + (ω_r + b x)²
/// from u_s = R_s i_s + j (ω_r + ω_σ x) ψ. Positive x motors at positive ω_r and regenerates at negative.
template <class T = double>
class VoltageDemand {
 public:
  /// What of N depends on the machine alone.
  struct Machine {
    T a{};                ///< R_s/L_s [rad/s]
    T omega_sigma{};      ///< slip frequency of the breakdown torque, 1/(σ τ_r) [rad/s]
    T twice_b_less_a{};   ///< 2 (b − a) [rad/s]
    T square{};           ///< b² − 2 a ω_σ [rad²/s²]
    T square_of_sigma{};  ///< ω_σ² [rad²/s²]

    explicit constexpr Machine(const InductionMachineParameters<T>& m) noexcept
        : a{m.r_s / m.l_s()}, omega_sigma{m.l_s() / (m.sigma_l_s() * m.tau_r())} {
      const T b = omega_sigma + a * m.l_s() / m.sigma_l_s();
      twice_b_less_a = T(2) * (b - a);
      square = b * b - T(2) * a * omega_sigma;
      square_of_sigma = omega_sigma * omega_sigma;
    }
  };

  constexpr VoltageDemand(const Machine& m, T omega_r) noexcept
      : n0_{m.a * m.a + omega_r * omega_r},
        n1_{m.twice_b_less_a * omega_r},
        n2_{m.square + omega_r * omega_r},
        n3_{T(2) * m.omega_sigma * omega_r},
        n4_{m.square_of_sigma} {}

  /// N(x). [rad²/s²]
  [[nodiscard]] constexpr T at(T x) const noexcept {
    return n0_ + x * (n1_ + x * (n2_ + x * (n3_ + x * n4_)));
  }

  /// N(0). [rad²/s²]
  [[nodiscard]] constexpr T without_torque() const noexcept { return n0_; }

  /// N'(x). [rad²/s²]
  [[nodiscard]] constexpr T slope(T x) const noexcept {
    return n1_ + x * (T(2) * n2_ + x * (T(3) * n3_ + x * T(4) * n4_));
  }

  /// True where the torque at constant voltage, which goes as x/N(x), rises with x. N(x)/x is convex in
  /// (0, 1], so that this holds up to one x and not beyond:  N(x) > x N'(x).
  [[nodiscard]] constexpr bool torque_rises(T x) const noexcept {
    return n0_ > x * x * (n2_ + x * (T(2) * n3_ + x * T(3) * n4_));
  }

 private:
  T n0_;
  T n1_;
  T n2_;
  T n3_;
  T n4_;
};

}  // namespace sextant
