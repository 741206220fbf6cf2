#pragma once

#include <Eigen/Core>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/flux_pair.hpp"
#include "sextant/plant/induction_magnetics.hpp"
#include "sextant/plant/inverse_inductance.hpp"
#include "sextant/plant/iron_loss.hpp"
#include "sextant/plant/machine_slopes.hpp"

namespace sextant {

/// `MachineSlopes` of the induction machine. The back-EMF counts as that of the machine without saturation,
/// with which a Newton iteration takes more steps to the same solution.
template <class T = double>
class InductionSlopes {
 public:
  /// Of one machine, whose parts must outlive this object.
  InductionSlopes(const InductionMachineParameters<T>& parameters, const InductionMagnetics<T>& magnetics,
                  const IronLoss<T>& iron_loss) noexcept SEXTANT_NONBLOCKING
      : m_{parameters},
        magnetics_{magnetics},
        iron_loss_{iron_loss},
        k_r_{parameters.k_r()},
        inverse_sigma_l_s_{T(1) / parameters.sigma_l_s()} {}

  /// At the flux linkages [Wb] and the mechanical speed [rad/s].
  [[nodiscard]] MachineSlopes<T> operator()(const FluxPair<T>& psi,
                                            T omega_m) const noexcept SEXTANT_NONBLOCKING {
    MachineSlopes<T> slopes;
    slopes.emf_share = k_r_;
    put_stator(slopes);
    put_rotor(psi, omega_m, slopes);
    put_torque(psi, slopes);
    if (magnetics_.saturates()) add_saturation(psi, slopes);
    if (iron_loss_.acts()) add_iron_loss(psi, omega_m, slopes);
    return slopes;
  }

 private:
  using Block = Eigen::Matrix<T, 2, 2>;
  using Column = Eigen::Matrix<T, 2, 1>;

  /// −R_s i_s, i_s = (psi_s − k_r psi_r)/σL_s
  void put_stator(MachineSlopes<T>& slopes) const noexcept SEXTANT_NONBLOCKING {
    slopes.stator.template leftCols<2>() = -m_.r_s * inverse_sigma_l_s_ * Block::Identity();
    slopes.stator.template middleCols<2>(2) = m_.r_s * k_r_ * inverse_sigma_l_s_ * Block::Identity();
  }
  /// −R_r i_r + j p omega_m psi_r, i_r = psi_r/L_r − k_r i_s
  void put_rotor(const FluxPair<T>& psi, T omega_m,
                 MachineSlopes<T>& slopes) const noexcept SEXTANT_NONBLOCKING {
    const T p = T(m_.pole_pairs);
    Block turn;
    turn << T(0), T(-1), T(1), T(0);
    slopes.rotor.template leftCols<2>() = m_.r_r * k_r_ * inverse_sigma_l_s_ * Block::Identity();
    slopes.rotor.template middleCols<2>(2) =
        (p * omega_m) * turn -
        m_.r_r * (T(1) / m_.l_r() + k_r_ * k_r_ * inverse_sigma_l_s_) * Block::Identity();
    slopes.rotor.col(4) = Column{-p * psi.r.beta, p * psi.r.alpha};
  }
  /// 3/2 p k_r/σL_s (psi_r × psi_s)
  void put_torque(const FluxPair<T>& psi, MachineSlopes<T>& slopes) const noexcept SEXTANT_NONBLOCKING {
    const T gain = T(1.5) * T(m_.pole_pairs) * k_r_ * inverse_sigma_l_s_;
    slopes.torque << -gain * psi.r.beta, gain * psi.r.alpha, gain * psi.s.beta, -gain * psi.s.alpha, T(0);
  }

  /// By di_s/dpsi_s beyond that of the linear machine, and what the leakage adds beside: to the torque
  /// −3/2 p gamma g (psi_s × psi_r) with the g of `added_leakage` across.
  void add_saturation(const FluxPair<T>& psi, MachineSlopes<T>& slopes) const noexcept SEXTANT_NONBLOCKING {
    InverseInductance<T> inverse = magnetics_.inverse_inductance(psi.s, psi.r);
    inverse.across -= inverse_sigma_l_s_;
    slopes.stator.template leftCols<2>() -= m_.r_s * block_of(inverse);
    if (!magnetics_.has_saturated_leakage()) return;
    const T gamma = magnetics_.gamma();
    const InverseInductance<T> added = magnetics_.added_leakage(psi.s, psi.r);
    const Block by_current = block_of(added);
    slopes.stator.template middleCols<2>(2) += m_.r_s * gamma * by_current;
    slopes.rotor.template leftCols<2>() += m_.r_r * gamma * by_current;
    slopes.rotor.template middleCols<2>(2) -= m_.r_r * gamma * gamma * by_current;
    const SpaceVector<T> along = added.axis;
    const T square = dot(along, along);
    const T bend = square > T(0) ? cross(psi.s, psi.r) * added.added_along / square : T(0);
    typename MachineSlopes<T>::Row row;
    row << added.across * psi.r.beta + bend * along.alpha, -added.across * psi.r.alpha + bend * along.beta,
        -(added.across * psi.s.beta + gamma * bend * along.alpha),
        -(-added.across * psi.s.alpha + gamma * bend * along.beta), T(0);
    slopes.torque -= T(1.5) * T(m_.pole_pairs) * gamma * row;
  }

  /// From the slopes of f to those of dpsi_r/dt (`IronLoss`), and of the torque 3/2 p/R_r (f − dpsi_r/dt) ×
  /// psi_r.
  void add_iron_loss(const FluxPair<T>& psi, T omega_m,
                     MachineSlopes<T>& slopes) const noexcept SEXTANT_NONBLOCKING {
    const SpaceVector<T> r = psi.r;
    const T p = T(m_.pole_pairs);
    const SpaceVector<T> f = (p * omega_m) * rotate_90(r) - m_.r_r * magnetics_.rotor_current(psi.s, r);
    const SpaceVector<T> lost = f - iron_loss_.shortened(f, r);
    const auto by = iron_loss_.slopes(f, r);
    const SpaceVector<T> unit = direction(f);
    const SpaceVector<T> unit_r = direction(r);
    const Column along{unit.alpha, unit.beta};
    const Block passed = by.across * Block::Identity() + (by.along - by.across) * along * along.transpose();
    const typename MachineSlopes<T>::Pair before = slopes.rotor;
    slopes.rotor = passed * before;
    slopes.rotor.template middleCols<2>(2) +=
        by.by_flux * along * Column{unit_r.alpha, unit_r.beta}.transpose();
    typename MachineSlopes<T>::Row torque =
        Eigen::Matrix<T, 1, 2>{r.beta, -r.alpha} * (before - slopes.rotor);
    torque[2] -= lost.beta;
    torque[3] += lost.alpha;
    slopes.torque += T(1.5) * p / m_.r_r * torque;
  }

  [[nodiscard]] static Block block_of(const InverseInductance<T>& inverse) noexcept SEXTANT_NONBLOCKING {
    const T square = dot(inverse.axis, inverse.axis);
    const Column axis{inverse.axis.alpha, inverse.axis.beta};
    const T along = square > T(0) ? inverse.added_along / square : T(0);
    return inverse.across * Block::Identity() + along * axis * axis.transpose();
  }

  const InductionMachineParameters<T>& m_;
  const InductionMagnetics<T>& magnetics_;
  const IronLoss<T>& iron_loss_;
  T k_r_;
  T inverse_sigma_l_s_;  ///< [1/H]
};

}  // namespace sextant
