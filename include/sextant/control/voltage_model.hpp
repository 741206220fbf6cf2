#pragma once

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/two_level_inverter.hpp"

namespace sextant {

/// Voltage model of the stator flux, ψ_s = ∫ (u_s − R_s i_s) dt (paper, 2.2.1 and Figure 2).
/// Sampled: the voltage is exact, from the applied pattern; the current enters by the trapezoidal rule. An
/// open integrator: errors of its initial value and of R_s do not decay.
template <class T = double>
class VoltageModel {
 public:
  constexpr explicit VoltageModel(T r_s) noexcept : r_s_{r_s} {}

  /// dψ_s/dt = u_s − R_s i_s. [V]
  [[nodiscard]] constexpr SpaceVector<T> derivative(SpaceVector<T> u_s, SpaceVector<T> i_s) const noexcept {
    return u_s - r_s_ * i_s;
  }

  /// Advances ψ_s over the applied pattern; i_s [A] and u_dc [V] are measured at its end, i_s_before [A] at
  /// its beginning. Every leg must have been driven.
  constexpr void step(const GatePattern& applied, T u_dc, SpaceVector<T> i_s_before,
                      SpaceVector<T> i_s) noexcept {
    const SpaceVector<T> i_mean = T(0.5) * (i_s_before + i_s);
    for (const GateSegment& segment : applied.segments()) {
      const T dt = T(segment.duration_ns) * T(1e-9);
      psi_s_ += dt * derivative(stator_voltage(segment.state, u_dc), i_mean);
    }
  }

  [[nodiscard]] constexpr SpaceVector<T> psi_s() const noexcept { return psi_s_; }  ///< [Wb]
  constexpr void set(SpaceVector<T> psi_s) noexcept { psi_s_ = psi_s; }
  constexpr void set_r_s(T r_s) noexcept { r_s_ = r_s; }  ///< [Ω]

 private:
  T r_s_;
  SpaceVector<T> psi_s_{};
};

}  // namespace sextant
