#pragma once

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/safety/applied_volt_seconds.hpp"

namespace sextant {

/// Means over one averaging time of the torque monitor.
template <class T = double>
struct TorqueMeans {
  T duration{};         ///< of the averaging time [s]
  T commanded{};        ///< torque [N·m]
  T reached{};          ///< torque that there has been time to reach [N·m]
  T omega_m{};          ///< mechanical speed [rad/s]
  T current_squared{};  ///< |i_s|² [A²]
  T flux_squared{};     ///< |ψ_r|² [Wb²]
  T along{};            ///< ψ_r · i_s [Wb·A]
  T across{};           ///< ψ_r × i_s [Wb·A]
  T power{};            ///< (u_s − R_s i_s − σL_s di_s/dt) · i_s: 2/3 of that into the rotor flux [W]
};

/// Sums of the torque monitor over the control periods of one averaging time: the whole work of a period but
/// for the flux.
template <class T = double>
class TorqueWindow {
 public:
  constexpr explicit TorqueWindow(const InductionMachineParameters<T>& machine) noexcept
      : r_s_{machine.r_s}, sigma_l_s_{machine.sigma_l_s()} {}

  /// Adds a period of dt [s] with its applied pattern, in which every leg was driven; voltage [V], current
  /// [A], rotor flux [Wb] and speed [rad/s] are those at its end, i_before [A] at its beginning. The voltage
  /// behind R_s and σL_s is k_r dψ_r/dt, which hardly changes within a period: its product with the mean
  /// current is the mean power, however many segments the pattern has. beyond: as `applied_volt_seconds`.
  constexpr void add(const GatePattern& applied, T dt, T u_dc, SpaceVector<T> i_before, SpaceVector<T> i_s,
                     SpaceVector<T> psi_r, T omega_m, T commanded, T reached,
                     const ThreePhase<T>& beyond = {}) noexcept {
    const SpaceVector<T> i_mean = T(0.5) * (i_before + i_s);
    const SpaceVector<T> volt_seconds = clarke(applied_volt_seconds(applied, u_dc, beyond)) -
                                        (r_s_ * dt) * i_mean - sigma_l_s_ * (i_s - i_before);
    ++count_;
    sums_.duration += dt;
    sums_.commanded += commanded;
    sums_.reached += reached;
    sums_.omega_m += omega_m;
    sums_.current_squared += dot(i_s, i_s);
    sums_.flux_squared += dot(psi_r, psi_r);
    sums_.along += dot(psi_r, i_s);
    sums_.across += cross(psi_r, i_s);
    sums_.power += dot(volt_seconds, i_mean);
  }

  [[nodiscard]] constexpr T duration() const noexcept { return sums_.duration; }  ///< so far [s]

  /// The means of what was added; there must be something.
  [[nodiscard]] constexpr TorqueMeans<T> means() const noexcept {
    const T weight = T(1) / T(count_);
    return {.duration = sums_.duration,
            .commanded = weight * sums_.commanded,
            .reached = weight * sums_.reached,
            .omega_m = weight * sums_.omega_m,
            .current_squared = weight * sums_.current_squared,
            .flux_squared = weight * sums_.flux_squared,
            .along = weight * sums_.along,
            .across = weight * sums_.across,
            .power = sums_.power / sums_.duration};
  }

  constexpr void clear() noexcept {
    sums_ = {};
    count_ = 0;
  }

 private:
  T r_s_;
  T sigma_l_s_;
  TorqueMeans<T> sums_{};
  int count_{0};
};

}  // namespace sextant
