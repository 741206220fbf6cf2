#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sextant/core/description.hpp"
#include "sextant/drive/torque_capability.hpp"

namespace sextant {

/// The stator flux of a torque, where voltage and breakdown torque leave a choice.
enum class FluxOptimum : std::uint8_t {
  constant,               ///< the configured flux
  max_torque_per_ampere,  ///< least stator current
  min_loss                ///< least loss in stator, rotor and iron
};

/// What `OptimalFlux` sees of one period.
template <class T = double>
struct FluxDemand {
  T torque{};              ///< torque reference, within the available range [N·m]
  T omega_m{};             ///< mechanical speed [rad/s]
  bool needs_full_flux{};  ///< flux is built up, or limits the torque: as much as the speed range allows
  T most{T(1)};  ///< share that the voltage allows beside the torque, `TorqueCapability::flux_share` [-]
};

/// Flux reference by torque reference, as a share of the configured flux ψ. In steady state the flux ψ_s
/// that makes a torque follows from the relative slip x of `steady_state`, and in the frame of the rotor
/// flux, with i_d = ψ_r/L_m, tan(angle between the fluxes) = σ i_q/i_d = x:
///   (ψ_s/ψ)² = |τ_e|/(2 T_b) · (1/x + x),   i_d = ψ_s/(L_s √(1 + x²)),   i_q = x i_d/σ
/// T_b is the breakdown torque at ψ. Slip of the least current, which is i_d = |i_q|:
///   x = σ
/// Loss in stator, rotor (current k_r i_q) and iron (resistance R_fe per phase, across the voltage that ψ_s
/// induces), at the stator frequency ω_s = ω_r + ω_σ x of a motor, ω_σ = 1/(σ τ_r), ω_r < 0 of a generator:
///   P = 3/2 (R_s |i_s|² + k_r² R_r i_q² + (ω_s ψ_s)²/R_fe)
///     = 3/2 ψ_s² ((c_d + c_q x²)/(1 + x²) + ω_s²/R_fe),   c_d = R_s/L_s²,   c_q = (R_s + k_r² R_r)/(σL_s)²
/// dP/dx = 0 at constant torque gives the slip of the least loss, one iteration of which a step makes,
///   x² = (c_d + ω_r²/R_fe)/(c_q + (ω_r² + 4 ω_r ω_σ x + ω_σ² (1 + 3 x²))/R_fe)
/// and without iron loss i_d/|i_q| = √((R_s + k_r² R_r)/R_s). The slip stays where `TorqueCapability` has its
/// limits: at most that of `breakdown_use`, and where less flux than of the least current is wanted, at most
///   x = q + √(q² − σ²),   q = σ² T_b (I L_s/ψ)²/|τ_e|
/// at which the torque takes the current limit I, and one for which the voltage suffices.
/// The flux stays above `least_share`, from which torque starts, and below the limit by the voltage. It rises
/// at once, as `FluxSlew` lets it, and falls with the time constant 3 τ_r, so that it does not follow a
/// torque that comes and goes.
/// The aim is that of A. Ammar, A. Benakcha, A. Bourek, "Closed loop torque SVM-DTC based on robust super
/// twisting speed controller of induction motor drive with efficiency optimization", Int. J. Hydrogen Energy
/// 42 (2017) 17940–17952; the equations are those of the T-equivalent circuit.
template <class T = double>
class OptimalFlux {
 public:
  struct Parameters {
    static constexpr T unlimited = std::numeric_limits<T>::infinity();

    FluxOptimum optimum{FluxOptimum::constant};
    T least_share{T(0.4)};              ///< least flux, as a share of the configured one [-]
    T iron_loss_resistance{unlimited};  ///< R_fe per phase; unlimited: no iron loss [Ω]

    [[nodiscard]] const char* validate() const noexcept {
      if (!(least_share > T(0) && least_share <= T(1)))
        return "the least share of the flux must be in (0, 1]";
      if (!(iron_loss_resistance > T(0))) return "the resistance of the iron loss must be above zero";
      return nullptr;
    }

    friend void describe(Description& d, Parameters& p) {
      auto& [kind, share, iron_resistance] = p;
      d.choice(
          "flux_optimum", kind,
          {{"constant", FluxOptimum::constant},
           {"max_torque_per_ampere", FluxOptimum::max_torque_per_ampere},
           {"min_loss", FluxOptimum::min_loss}},
          "flux reference: control.flux_reference_wb at every torque; or less of it at part load, for the "
          "least stator current, or for the least loss in stator, rotor and iron",
          Changes::always);
      d.number("flux_least_share", share,
               {"", 0.05, 1,
                "least flux of max_torque_per_ampere and min_loss, as a share of control.flux_reference_wb",
                Changes::always});
      d.number(
          "iron_loss_resistance_ohm", NumberMember::unless_infinite(iron_resistance),
          {"ohm", 1e-3, 1e9,
           "resistance of the iron loss per phase, at all frequencies, across the voltage that the "
           "stator flux induces: min_loss uses it, flux models and torque monitor subtract what it takes "
           "of the torque; what the simulated machine loses is plant.iron_loss; not set: no iron loss",
           Changes::always});
    }
  };

  /// Machine, flux and limits are those of the available torque.
  OptimalFlux(const Parameters& p, const typename TorqueCapability<T>::Parameters& limits) noexcept
      : optimum_{p.optimum},
        least_square_{p.least_share * p.least_share},
        machine_{limits.machine, T(1) / p.iron_loss_resistance},
        inverse_twice_breakdown_{T(0.5) / breakdown_torque(limits.machine, limits.flux_reference)},
        most_slip_{relative_slip(limits.breakdown_use, T(1))},
        slip_{std::min(without_iron_loss(), most_slip_)} {
    const T current = limits.current_limit * limits.machine.sigma_l_s() / limits.flux_reference;
    current_torque_ = T(0.5) * current * current / inverse_twice_breakdown_;
  }

  /// Takes the parameters of another one for the same machine and flux reference; the share goes on from
  /// where it is.
  constexpr void take_parameters(const OptimalFlux& from) noexcept {
    const OptimalFlux before{*this};
    *this = from;
    share_ = before.share_;
    if (optimum_ == FluxOptimum::min_loss && machine_.iron > T(0)) slip_ = std::min(before.slip_, most_slip_);
  }

  /// One period of dt [s]: the share of the flux reference. `capability` has made its step. [-]
  [[nodiscard]] T step(const FluxDemand<T>& demand, const TorqueCapability<T>& capability, T dt) noexcept {
    if (optimum_ == FluxOptimum::constant) return demand.most;
    if (demand.needs_full_flux) {
      share_ = T(1);
      return demand.most;
    }
    const T wanted = wanted_share(demand, capability);
    const T fall = std::min(T(1), dt * machine_.fall_rate);
    share_ = wanted < share_ ? share_ + (wanted - share_) * fall : wanted;
    return std::min(share_, demand.most);
  }

 private:
  static constexpr T least_slip = T(1e-4);  // of a link without voltage, which allows none

  /// What of the equations depends on the machine alone.
  struct Machine {
    T pole_pairs;   ///< p [-]
    T sigma;        ///< [-]
    T omega_sigma;  ///< ω_σ [rad/s]
    T c_d;          ///< [Ω/H²]
    T c_q;          ///< [Ω/H²]
    T iron;         ///< 1/R_fe [1/Ω]
    T fall_rate;    ///< 1/(3 τ_r) [1/s]

    Machine(const InductionMachineParameters<T>& m, T conductance) noexcept
        : pole_pairs{T(m.pole_pairs)},
          sigma{m.sigma_l_s() / m.l_s()},
          omega_sigma{T(1) / (sigma * m.tau_r())},
          c_d{m.r_s / (m.l_s() * m.l_s())},
          c_q{(m.r_s + m.k_r() * m.k_r() * m.r_r) / (m.sigma_l_s() * m.sigma_l_s())},
          iron{conductance},
          fall_rate{T(1) / (T(3) * m.tau_r())} {}
  };

  /// Slip of the optimum where there is no iron loss. [-]
  [[nodiscard]] T without_iron_loss() const noexcept {
    return optimum_ == FluxOptimum::min_loss ? std::sqrt(machine_.c_d / machine_.c_q) : machine_.sigma;
  }

  [[nodiscard]] T wanted_share(const FluxDemand<T>& demand, const TorqueCapability<T>& capability) noexcept {
    const T torque = std::abs(demand.torque);
    follow_iron_loss(demand.torque < T(0) ? -demand.omega_m : demand.omega_m);
    const T x = std::max(least_slip, capability.within_voltage(demand.torque, within_current(torque, slip_)));
    const T square = torque * inverse_twice_breakdown_ * (T(1) / x + x);
    return std::sqrt(std::clamp(square, least_square_, T(1)));
  }

  /// One iteration for the slip of the least loss at a speed, positive of a motor [rad/s].
  void follow_iron_loss(T omega_m) noexcept {
    if (optimum_ != FluxOptimum::min_loss || machine_.iron == T(0)) return;
    const Machine& m = machine_;
    const T omega_r = m.pole_pairs * omega_m;
    const T square = omega_r * omega_r;
    const T of_slip =
        m.omega_sigma * (T(4) * omega_r * slip_ + m.omega_sigma * (T(1) + T(3) * slip_ * slip_));
    const T x_squared = (m.c_d + m.iron * square) / (m.c_q + m.iron * (square + of_slip));
    slip_ = std::min(most_slip_, std::sqrt(x_squared));
  }

  /// A slip of at most that at which a torque [N·m] takes the current limit.
  [[nodiscard]] T within_current(T torque, T x) const noexcept {
    if (x <= machine_.sigma) return x;
    const T q = current_torque_ / torque;
    const T rest = q * q - machine_.sigma * machine_.sigma;
    return rest > T(0) ? std::min(x, q + std::sqrt(rest)) : machine_.sigma;
  }

  FluxOptimum optimum_;
  T least_square_;  ///< of the share of the flux [-]
  Machine machine_;
  T inverse_twice_breakdown_;  ///< 1/(2 T_b) [1/(N·m)]
  T current_torque_{};         ///< q |τ_e| [N·m]
  T most_slip_;                ///< of `breakdown_use` [-]
  T slip_;                     ///< of the optimum at the last speed [-]
  T share_{1};                 ///< before the limit by the voltage [-]
};

}  // namespace sextant
