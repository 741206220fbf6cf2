#pragma once

#include "sextant/control/flux_estimator_kind.hpp"
#include "sextant/core/drive_basis.hpp"

namespace sextant {

/// What every control method shares with the drive.
template <class T = double>
struct ControlBasis : DriveBasis<T> {
  FluxEstimatorKind flux_estimator{FluxEstimatorKind::hybrid};
  bool adapts_parameters{true};  ///< R_s, R_r and L_m follow the machine, with the kinds that identify them
  T current_limit{T(160)};       ///< of the stator current vector, as the drive has it [A]
};

}  // namespace sextant
