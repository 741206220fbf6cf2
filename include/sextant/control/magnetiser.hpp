#pragma once

#include <cmath>

#include "sextant/core/description.hpp"
#include "sextant/core/drive_basis.hpp"
#include "sextant/core/drive_limits.hpp"
#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant {

/// Builds up flux without torque, at any speed, by a current in the direction of the rotor flux. Its
/// reference is the limit until the flux is reached, and then the current that holds the flux, to which it
/// falls before torque control starts, so that torque starts without a surge.
template <class T = double>
class Magnetiser {
 public:
  struct Parameters {
    T current_limit{T(40)};      ///< of the current vector [A]
    T hand_over_current{T(30)};  ///< largest |i_s| at which torque control may start [A]

    /// Those of `drive_limits`.
    [[nodiscard]] static Parameters by_default(const DriveBasis<T>& basis) noexcept {
      const DriveLimits<T> limits = drive_limits(basis.machine, basis.flux_reference, basis.u_dc);
      return {.current_limit = limits.magnetising_current, .hand_over_current = limits.hand_over_current};
    }

    friend void describe(Description& d, Parameters& p, const Parameters& by_default) {
      auto& [limit, hand_over] = p;
      d.defaulted("magnetising_current_a", limit, by_default.current_limit,
                  {"A", 0.1, 1e5,
                   "limit of the stator current's magnitude while the flux is built up at standstill: the "
                   "larger, the sooner there is torque"});
      d.defaulted("hand_over_current_a", hand_over, by_default.hand_over_current,
                  {"A", 0.1, 1e5,
                   "largest magnitude of the stator current at which torque control follows magnetising"});
    }

    [[nodiscard]] const char* validate() const noexcept {
      if (!(std::isfinite(current_limit) && current_limit > T(0))) {
        return "the magnetising current limit must be above zero";
      }
      if (!(std::isfinite(hand_over_current) && hand_over_current > T(0))) {
        return "the hand-over current must be above zero";
      }
      return nullptr;
    }

    /// The same with the machine and the flux [Wb] that it is to have.
    [[nodiscard]] const char* validate(const InductionMachineParameters<T>& machine,
                                       T flux_reference) const noexcept {
      if (const char* problem = validate()) return problem;
      // Magnetising ends only if the current, errors of its sensors included, reaches ψ_ref / L_s.
      if (!(T(0.9) * current_limit * machine.l_s() > flux_reference)) {
        return "the magnetising current limit is too low for the flux reference";
      }
      // Below ψ_ref / L_s the flux would have to fall again before the current is low enough.
      if (!(T(0.9) * hand_over_current * machine.l_s() > flux_reference)) {
        return "the hand-over current is too low for the flux reference";
      }
      return nullptr;
    }
  };

  constexpr explicit Magnetiser(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// Magnitude of the current reference in the coming period [A]. psi_s and psi_ref: stator flux and its
  /// reference [Wb]; holding_current: ψ_ref/L_s [A]; current: |i_s| [A]; fed_current: the largest that
  /// the link voltage can keep [A]; leakage: σL_s [H]; settled: the flux estimate may be relied on.
  [[nodiscard]] constexpr T step(T psi_s, T psi_ref, T holding_current, T current, T fed_current, T leakage,
                                 bool settled) noexcept {
    const T highest = parameters_.current_limit;
    const T limit = fed_current < highest ? fed_current : highest;
    // What of the flux remains when the current has fallen; the link voltage keeps it by itself.
    const T falls = fed_current < highest ? T(0) : current - holding_current;
    const bool enough = psi_s - leakage * falls >= T(0.995) * psi_ref;
    reached_ = reached_ || (enough && settled);
    done_ = reached_ && current <= parameters_.hand_over_current;
    return reached_ || enough || limit < holding_current ? holding_current : limit;
  }

  [[nodiscard]] constexpr bool done() const noexcept { return done_; }
  [[nodiscard]] constexpr T current_limit() const noexcept { return parameters_.current_limit; }  ///< [A]

  constexpr void reset() noexcept {
    reached_ = false;
    done_ = false;
  }

 private:
  Parameters parameters_;
  bool reached_{false};
  bool done_{false};
};

}  // namespace sextant
