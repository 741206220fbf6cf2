#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/thermal_parameters.hpp"

namespace sextant {

/// Temperatures of winding, rotor and housing by a linear network of heat capacities and conductances:
///   C_k dϑ_k/dt = P_k − Σ_j G_kj (ϑ_k − ϑ_j) − G_k (ϑ_k − ϑ_ambient)
/// Between two steps the powers are constant, and the temperatures move without any error of discretisation,
/// whatever the step. Source: P. H. Mellor, D. Roberts, D. R. Turner, "Lumped parameter thermal model for
/// electrical machines of TEFC design", IEE Proc. B 138 (1991) 205–218.
///
/// With θ = ϑ − ϑ_ambient the matrix C^(−1/2) G C^(−1/2) is symmetric: in its eigenvectors the network is
/// three nodes that do not know of each other,
///   z(t + h) = e^(−λh) z(t) + (1 − e^(−λh))/(λh) q,
/// q being the heat of the step, P h, in the same coordinates.
template <class T = double>
class ThermalNetwork {
 public:
  /// The parameters must be valid, and act.
  explicit ThermalNetwork(const ThermalParameters<T>& parameters)
      : ambient_{parameters.ambient}, root_capacity_{column(parameters.capacity).cwiseSqrt()} {
    const Eigen::SelfAdjointEigenSolver<Matrix> modes{root_capacity_.cwiseInverse().asDiagonal() *
                                                      conductances(parameters) *
                                                      root_capacity_.cwiseInverse().asDiagonal()};
    rate_ = modes.eigenvalues();
    modes_ = modes.eigenvectors();
    z_ = modes_.transpose() *
         root_capacity_.cwiseProduct(column(parameters.begin()) - Column::Constant(ambient_));
  }

  /// Over h [s], in which each node has got that heat [J], evenly.
  void step(const ThermalNodes<T>& heat, T h) noexcept SEXTANT_NONBLOCKING {
    const Column q = modes_.transpose() * column(heat).cwiseQuotient(root_capacity_);
    for (int k = 0; k < nodes; ++k) {
      const T x = rate_[k] * h;
      z_[k] = std::exp(-x) * z_[k] + (x > T(0) ? -std::expm1(-x) / x : T(1)) * q[k];
    }
  }

  /// [°C]
  [[nodiscard]] ThermalNodes<T> temperatures() const noexcept SEXTANT_NONBLOCKING {
    const Column theta = (modes_ * z_).cwiseQuotient(root_capacity_);
    return {ambient_ + theta[0], ambient_ + theta[1], ambient_ + theta[2]};
  }

 private:
  static constexpr int nodes = 3;
  using Matrix = Eigen::Matrix<T, nodes, nodes>;
  using Column = Eigen::Matrix<T, nodes, 1>;

  static Column column(const ThermalNodes<T>& x) noexcept SEXTANT_NONBLOCKING {
    return {x.winding, x.rotor, x.housing};
  }
  static Matrix conductances(const ThermalParameters<T>& p) {
    const T wr = p.winding_to_rotor, wh = p.winding_to_housing, rh = p.rotor_to_housing;
    Matrix g;
    g << p.to_ambient.winding + wr + wh, -wr, -wh,  //
        -wr, p.to_ambient.rotor + wr + rh, -rh,     //
        -wh, -rh, p.to_ambient.housing + wh + rh;
    return g;
  }

  T ambient_;             ///< [°C]
  Column root_capacity_;  ///< [√(J/K)]
  Column rate_;           ///< λ [1/s]
  Matrix modes_;          ///< eigenvectors, a column each
  Column z_;              ///< [√(J·K)]
};

}  // namespace sextant
