#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/safety/torque_window.hpp"

namespace sextant {

/// Torque of a candidate machine by the two methods of the torque monitor.
template <class T = double>
struct CandidateTorque {
  T by_current{};      ///< [N·m]
  T by_power{};        ///< meaningful where `omega_e` is not zero [N·m]
  T per_stator_ohm{};  ///< change of `by_power` per ohm by which the true R_s is higher [N·m/Ω]
  T omega_e{};         ///< electrical speed of the rotor flux; zero without flux [rad/s]
};

/// A machine that the true one may be: its R_r and L_m are m_R and m_L times those of the torque monitor,
/// whose rotor flux ψ_r' is that of `MonitoredFlux`. The candidate's own flux is ψ_r = g ψ_r', g complex.
/// Both flux equations together give, with h = i_s/ψ_r' and in every frame,
///   dg/dt = (L_m/τ_r) h − g (1/τ_r + (L_m' h − 1)/τ_r')
/// so that one step of g per averaging time replaces a flux model per candidate, in transients also. With ψ_r
///   by current:  τ_e = 3/2 p k_r ψ_r × i_s
///   by power:    τ_e = 3/2 p (P − k_r (d|ψ_r|/dt)/|ψ_r| ψ_r·i_s)/ω_e,   P = k_r (dψ_r/dt)·i_s
/// where P is the measured power behind R_s and σL_s (`TorqueMeans::power`) and ω_e the speed of ψ_r. In a
/// steady state ω_e is that of the currents for every candidate, and the power balance depends on R_s alone.
template <class T = double>
class CandidateMachine {
 public:
  CandidateMachine() = default;

  /// `machine`: that of the monitor; flux whose square is below `least_flux_squared` [Wb²] counts as none.
  CandidateMachine(const InductionMachineParameters<T>& machine, T r_r_factor, T l_m_factor,
                   T least_flux_squared) noexcept
      : least_flux_squared_{least_flux_squared},
        r_r_factor_{r_r_factor},
        l_m_factor_{l_m_factor},
        pole_pairs_{T(machine.pole_pairs)} {
    set_machine(machine);
    g_ = {from_zero_, T(0)};
  }

  /// That of the monitor from here on; g stays.
  void set_machine(const InductionMachineParameters<T>& machine) noexcept {
    monitor_l_m_ = machine.l_m;
    monitor_inverse_tau_r_ = T(1) / machine.tau_r();
    InductionMachineParameters<T> own = machine;
    own.r_r *= r_r_factor_;
    own.l_m *= l_m_factor_;
    k_r_ = own.k_r();
    inverse_tau_r_ = T(1) / own.tau_r();
    rate_ = own.l_m * inverse_tau_r_;
    from_zero_ = rate_ / (monitor_l_m_ * monitor_inverse_tau_r_);
  }

  /// dt [s] in which both fluxes decayed without current.
  void decay(T dt) noexcept {
    // Of fluxes further apart the larger one is also small.
    constexpr T most = T(2);
    g_ = std::exp(std::min(dt * (monitor_inverse_tau_r_ - inverse_tau_r_), most)) * g_;
  }

  /// Advances g by one averaging time. The step is implicit, and so stable while flux builds up from zero.
  void step(const TorqueMeans<T>& m) noexcept {
    if (!(m.flux_squared > least_flux_squared_)) {
      g_ = {from_zero_, T(0)};
      return;
    }
    const T scale = m.duration / m.flux_squared;
    const SpaceVector<T> h{scale * m.along, scale * m.across};  // times dt [s/H]
    const SpaceVector<T> above = g_ + rate_ * h;
    const SpaceVector<T> below{T(1) + m.duration * (inverse_tau_r_ - monitor_inverse_tau_r_) +
                                   monitor_inverse_tau_r_ * monitor_l_m_ * h.alpha,
                               monitor_inverse_tau_r_ * monitor_l_m_ * h.beta};
    const T shrink = T(1) / dot(below, below);
    g_ = {shrink * dot(above, below), shrink * cross(below, above)};
  }

  /// g: rotor flux of the candidate by that of `MonitoredFlux`, at the end of the last averaging time. [-]
  [[nodiscard]] constexpr SpaceVector<T> flux_ratio() const noexcept { return g_; }

  [[nodiscard]] CandidateTorque<T> torque(const TorqueMeans<T>& m) const noexcept {
    CandidateTorque<T> out;
    const T gain = T(1.5) * pole_pairs_;
    const T along = g_.alpha * m.along + g_.beta * m.across;   // ψ_r · i_s
    const T across = g_.alpha * m.across - g_.beta * m.along;  // ψ_r × i_s
    out.by_current = gain * k_r_ * across;
    if (!(m.flux_squared > least_flux_squared_)) return out;
    const T share = rate_ / (dot(g_, g_) * m.flux_squared);
    out.omega_e = pole_pairs_ * m.omega_m + share * across;
    if (out.omega_e == T(0)) return out;
    const T growth = share * along - inverse_tau_r_;  // (d|ψ_r|/dt)/|ψ_r| [1/s]
    const T scale = gain / out.omega_e;
    out.by_power = scale * (m.power - k_r_ * growth * along);
    out.per_stator_ohm = -scale * m.current_squared;
    return out;
  }

 private:
  T least_flux_squared_{};
  T r_r_factor_{};  ///< m_R [-]
  T l_m_factor_{};  ///< m_L [-]
  T monitor_l_m_{};
  T monitor_inverse_tau_r_{};
  T pole_pairs_{};
  T k_r_{};
  T inverse_tau_r_{};
  T rate_{};       ///< L_m/τ_r [Ω]
  T from_zero_{};  ///< g while flux builds up from zero: m_R but for the leakage [-]
  SpaceVector<T> g_{};
};

}  // namespace sextant
