#pragma once

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/electrical_rates.hpp"

namespace sextant {

/// The integral V of the stator voltage at one instant, and that of V itself, A.
template <class T = double>
struct VoltageMoments {
  SpaceVector<T> v{};  ///< ∫ u_s dt [Wb]
  SpaceVector<T> a{};  ///< ∫ V dt [Wb·s]
};

/// The smooth state of a plant whose stator voltage jumps: its state less what the voltage itself does to the
/// fluxes in the first two orders,
///   psi_s − V + a A,   psi_r − b A,   omega_m,   theta_m
/// with V = ∫ u_s dt, A = ∫ V dt, a = R_s/σL_s and b = R_r L_m/(L_s L_r − L_m²). Where the voltage jumps,
/// neither the smooth fluxes nor their first two derivatives do. For a machine that is not linear a and b are
/// those of a linear one; the change of variables is exact whatever they are.
template <class Plant>
class SmoothState {
 public:
  using T = typename Plant::Scalar;
  using MachineState = typename Plant::MachineState;

  explicit SmoothState(const Plant& plant) noexcept SEXTANT_NONBLOCKING : rates_{plant.electrical_rates()} {}

  /// The state of the machine whose smooth state is x.
  [[nodiscard]] MachineState machine(const MachineState& x,
                                     const VoltageMoments<T>& m) const noexcept SEXTANT_NONBLOCKING {
    return shifted(x, m.v - rates_.ss * m.a, rates_.rs * m.a);
  }
  /// The smooth state of the machine's x.
  [[nodiscard]] MachineState smooth(const MachineState& x,
                                    const VoltageMoments<T>& m) const noexcept SEXTANT_NONBLOCKING {
    return shifted(x, rates_.ss * m.a - m.v, -rates_.rs * m.a);
  }
  /// The slope of the smooth state from that of `DrivePlant::undriven_derivative`, and V.
  [[nodiscard]] MachineState slope(const MachineState& undriven,
                                   SpaceVector<T> v) const noexcept SEXTANT_NONBLOCKING {
    return shifted(undriven, rates_.ss * v, -rates_.rs * v);
  }

  /// x with a stator flux linkage that is larger by v. [Wb]
  [[nodiscard]] static MachineState raised(MachineState x, SpaceVector<T> v) noexcept SEXTANT_NONBLOCKING {
    x[Plant::psi_s_alpha] += v.alpha;
    x[Plant::psi_s_beta] += v.beta;
    return x;
  }

 private:
  static MachineState shifted(const MachineState& at, SpaceVector<T> s,
                              SpaceVector<T> r) noexcept SEXTANT_NONBLOCKING {
    MachineState x = raised(at, s);
    x[Plant::psi_r_alpha] += r.alpha;
    x[Plant::psi_r_beta] += r.beta;
    return x;
  }

  ElectricalRates<T> rates_;
};

}  // namespace sextant
