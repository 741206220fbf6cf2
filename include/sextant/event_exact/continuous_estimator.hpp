#pragma once

#include <span>

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/appended_system.hpp"

namespace sextant {

/// The drive's voltage model in continuous time, appended to the plant and integrated with it, and the torque
/// reference, whose straight lines are a state so that root functions depend on the state alone:
///   dψ̂_s/dt = u_s − R̂_s i_s   (paper, 2.2.1 and Figure 2)
///   dT_ref/dt = slope
class ContinuousEstimator {
 public:
  static constexpr int size = 3;
  enum Index : std::size_t {
    psi_alpha = 0,        ///< estimated stator flux linkage, stationary frame [Wb]
    psi_beta = 1,         ///< [Wb]
    torque_reference = 2  ///< [N·m]
  };

  /// The drive's parameter of the stator resistance. [Ω]
  constexpr explicit ContinuousEstimator(double r_s) noexcept : r_s_{r_s} {}

  /// Slope of the torque reference. [N·m/s]
  constexpr void set_reference_slope(double slope) noexcept { slope_ = slope; }

  constexpr void derivative(const PlantQuantities<double>& plant, std::span<const double, 3>,
                            std::span<double, 3> slopes) const noexcept SEXTANT_NONBLOCKING {
    slopes[psi_alpha] = plant.u_s.alpha - r_s_ * plant.i_s.alpha;
    slopes[psi_beta] = plant.u_s.beta - r_s_ * plant.i_s.beta;
    slopes[torque_reference] = slope_;
  }

 private:
  double r_s_;      ///< [Ω]
  double slope_{};  ///< [N·m/s]
};

}  // namespace sextant
