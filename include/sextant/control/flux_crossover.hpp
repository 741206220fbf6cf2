#pragma once

#include <cmath>

#include "sextant/control/parameter_prior.hpp"
#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant {

/// ω_1: the stator frequency from which the flux follows from the voltage rather than from the current model,
///   ω_1² = (R_s/L_s)² + (δu/(ε ψ_ref))²
/// At R_s/L_s the magnetising current's resistive voltage is as large as that of the flux. An unknown voltage
/// δu moves the flux of the voltage model by δu/ω, which is as much as the parameters of the current model
/// may move its flux at ω = δu/(ε ψ_ref), ε² = ε_r² + ε_L² by `ParameterPrior`. [rad/s]
/// voltage_error: δu [V]; flux_reference: ψ_ref [Wb].
template <class T>
[[nodiscard]] T flux_crossover(const InductionMachineParameters<T>& machine, T voltage_error,
                               T flux_reference) noexcept {
  using Prior = ParameterPrior<T>;
  const T share = std::hypot(Prior::r_r_deviation, Prior::l_deviation);
  return std::hypot(machine.r_s / machine.l_s(), voltage_error / (share * flux_reference));
}

}  // namespace sextant
