#pragma once

#include "sextant/control/flux_estimator_kind.hpp"
#include "sextant/core/drive_basis.hpp"
#include "sextant/core/winding_resistance.hpp"

namespace sextant {

/// What every control method shares with the drive.
template <class T = double>
struct ControlBasis : DriveBasis<T> {
  FluxEstimatorKind flux_estimator{FluxEstimatorKind::hybrid};
  bool adapts_parameters{true};    ///< R_s, R_r and L_m follow the machine, with the kinds that identify them
  WindingResistance<T> winding{};  ///< by which R_s in use follows the winding's temperature
  T current_limit{T(160)};         ///< of the stator current vector, as the drive has it [A]
};

/// Parameters of a controller of class C: what it has in common with the drive, and what follows from that by
/// default. C::Parameters has `set_basis` for the one and `set_defaults` for the other.
template <class C, class T>
[[nodiscard]] typename C::Parameters default_parameters(const ControlBasis<T>& basis) noexcept {
  typename C::Parameters p;
  p.set_basis(basis);
  p.set_defaults(basis);
  return p;
}

}  // namespace sextant
