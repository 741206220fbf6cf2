#pragma once

#include <Eigen/Core>

namespace sextant {

/// ∂(dpsi_s/dt, dpsi_r/dt, tau_e)/∂(psi_s, psi_r, omega_m) of a machine at a given stator voltage, for
/// implicit integrators; columns in this order.
template <class T = double>
struct MachineSlopes {
  using Pair = Eigen::Matrix<T, 2, 5>;
  using Row = Eigen::Matrix<T, 1, 5>;
  Pair stator{Pair::Zero()};  ///< [1/s], [V·s/rad]
  Pair rotor{Pair::Zero()};   ///< the same
  Row torque{Row::Zero()};    ///< [N·m/Wb], [N·m·s/rad]
  T emf_share{};              ///< the back-EMF counts as emf_share dpsi_r/dt [-]
};

}  // namespace sextant
