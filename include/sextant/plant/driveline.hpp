#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/appended_system.hpp"
#include "sextant/plant/driveline_parameters.hpp"
#include "sextant/plant/road_load.hpp"

namespace sextant {

/// A load that the motor turns through a shaft with stiffness, damping and backlash, appended to the plant,
/// on which it acts by the torque of that shaft in place of the load torque:
///   dφ/dt   = omega_m − omega_2
///   J_2 domega_2/dt = tau − tau_l − tau_road(omega_2)
/// tau_l and the road load act on the load. All is referred to the motor's shaft
/// (`DrivelineParameters::referred`); of the load, omega_2/n is its speed, and n tau_l acts on it.
///
/// Without backlash tau = c φ + d dφ/dt. With a gap 2b the flanks touch or they do not:
///   ahead    tau = c (φ − b) + d dφ/dt ≥ 0
///   behind   tau = c (φ + b) + d dφ/dt ≤ 0
///   neither  tau = 0
/// A contact only pushes: it ends where its torque falls to zero, which with damping is before the shaft has
/// untwisted; what the shaft still stores there is lost in its damping. A contact begins where the gap is
/// crossed, with the jump d dφ/dt of the torque. The shaft has no mass. Source: M. Nordin,
/// P.-O. Gutman, "Controlling mechanical systems with backlash—a survey", Automatica 38 (2002) 1633–1649,
/// for the dead zone and what is wrong with it where a damped contact pulls.
///
/// The energies that it meters balance with the work of the machine's torque, `EnergyMeter::mechanical`:
///   E_m = E_friction + E_damping + E_load + W(t) − W(0),
///   W = ½ J omega_m² + ½ J_2 omega_2² + ½ c δ²,  δ = φ beyond the gap, 0 where no flanks touch
template <class T = double>
class Driveline {
 public:
  using Parameters = DrivelineParameters<T>;
  static constexpr int size = 6;
  static constexpr bool feeds_back = true;
  static constexpr bool keeps_link_voltage = true;
  static constexpr int event_count = 2;
  enum Index : std::size_t {
    twist = 0,       ///< φ, angle of the motor ahead of the load [rad]
    load_speed = 1,  ///< omega_2 [rad/s]
    flanks = 2,      ///< which touch, see `contact`; changes at events alone [-]
    damping = 3,     ///< lost in the shaft's damping [J]
    friction = 4,    ///< lost in the motor's viscous friction [J]
    load = 5         ///< work on load torque and road load [J]
  };
  /// Which flanks of the gap touch.
  enum class Contact : int { behind = -1, neither = 0, ahead = 1 };
  /// A contact begins once the gap is passed by this much; more where the scalar does not resolve it. [rad]
  static constexpr T twist_tolerance = T(1e-9);

  /// The parameters must be valid, and act. motor_inertia: J [kg·m²]; viscous_friction: B of the motor, whose
  /// loss is metered alone [N·m·s/rad]; road: on the load's side of the gear, its coupled inertia beside J_2.
  constexpr Driveline(const Parameters& parameters, T motor_inertia, T viscous_friction,
                      const RoadLoad<T>& road = {}) noexcept
      : ratio_{parameters.gear_ratio},
        motor_inertia_{motor_inertia},
        viscous_friction_{viscous_friction},
        road_{road} {
    const Parameters p = parameters.referred();
    inertia_ = p.inertia + road.coupled_inertia / (ratio_ * ratio_);
    stiffness_ = p.stiffness;
    damping_ = p.damping;
    half_gap_ = p.backlash / T(2);
    constexpr T resolved = T(16) * std::numeric_limits<T>::epsilon();
    tolerance_ = stiffness_ * std::max(twist_tolerance, resolved * half_gap_);
  }

  using Values = std::span<const T, std::size_t(size)>;
  using States = std::span<T, std::size_t(size)>;

  /// The equations above.
  constexpr void derivative(const PlantQuantities<T>& plant, Values y,
                            States dy) const noexcept SEXTANT_NONBLOCKING {
    const T slip = plant.omega_m - y[load_speed];
    const T tau_l = load_torque(y, plant.tau_given);
    dy[twist] = slip;
    dy[load_speed] = (plant.tau_l - tau_l) / inertia_;
    dy[flanks] = T(0);
    dy[damping] = (plant.tau_l - stiffness_ * deflection(y)) * slip;
    dy[friction] = viscous_friction_ * plant.omega_m * plant.omega_m;
    dy[load] = tau_l * y[load_speed];
  }

  /// In the middle of the gap, the load as fast as the motor.
  constexpr void begin(States y, T omega_m) const noexcept SEXTANT_NONBLOCKING {
    std::fill(y.begin(), y.end(), T(0));
    y[load_speed] = omega_m;
  }
  constexpr void act(Values y, T omega_m, PlantInputs<T>& inputs) const noexcept SEXTANT_NONBLOCKING {
    inputs.tau_l = is_free(y) ? T(0) : contact_torque(y, omega_m);
  }

  /// Of the contact ahead and of that behind: its torque, or by how much it is not there; 1 of what cannot
  /// come. [N·m]
  constexpr void events(Values y, T omega_m, const PlantInputs<T>&,
                        std::span<T, std::size_t(event_count)> g) const noexcept SEXTANT_NONBLOCKING {
    g[0] = g[1] = T(1);
    if (!has_gap()) return;
    if (!is_free(y)) {
      const bool ahead = contact(y) == Contact::ahead;
      g[ahead ? 0 : 1] = ahead ? contact_torque(y, omega_m) : -contact_torque(y, omega_m);
      return;
    }
    // Flanks that part do not touch before they approach, whatever the twist.
    const T parting = damping_ * (omega_m - y[load_speed]);
    g[0] = tolerance_ - stiffness_ * (y[twist] - half_gap_) - std::min(T(0), parting);
    g[1] = tolerance_ + stiffness_ * (y[twist] + half_gap_) + std::max(T(0), parting);
  }
  /// What the shaft stores goes into its damping where a contact ends.
  constexpr void on_event(int event, States y) const noexcept SEXTANT_NONBLOCKING {
    const T stored = elastic_energy(y);
    y[flanks] = !is_free(y) ? T(0) : event == 0 ? T(1) : T(-1);
    y[damping] += stored - elastic_energy(y);
  }
  /// A contact may end and that of the other flank begin.
  constexpr bool settle(States y, T omega_m, const PlantInputs<T>& given) const noexcept SEXTANT_NONBLOCKING {
    bool changed = false;
    for (int n = 0; n < 2; ++n) {
      std::array<T, std::size_t(event_count)> g;
      events(y, omega_m, given, g);
      if (!(g[0] < T(0) || g[1] < T(0))) break;
      on_event(g[0] < T(0) ? 0 : 1, y);
      changed = true;
    }
    return changed;
  }

  /// The shaft oscillates with √(c (1/J + 1/J_2)), and its damping decays with d (1/J + 1/J_2). [1/s²]
  [[nodiscard]] constexpr T rate_squared() const noexcept SEXTANT_NONBLOCKING {
    const T mobility = T(1) / motor_inertia_ + T(1) / inertia_;
    return stiffness_ * mobility + damping_ * mobility * damping_ * mobility;
  }
  [[nodiscard]] constexpr bool is_valid(Values) const noexcept SEXTANT_NONBLOCKING { return true; }

  /// Torque of the shaft, which drives the load and brakes the motor. [N·m]
  [[nodiscard]] constexpr T torque(Values y, T omega_m) const noexcept SEXTANT_NONBLOCKING {
    if (is_free(y)) return T(0);
    const T tau = contact_torque(y, omega_m);
    if (!has_gap()) return tau;
    return contact(y) == Contact::ahead ? std::max(T(0), tau) : std::min(T(0), tau);
  }
  /// Load torque with that of the road; given: on the load's side of the gear. [N·m]
  [[nodiscard]] constexpr T load_torque(Values y, T given) const noexcept SEXTANT_NONBLOCKING {
    return (given + road_.torque(y[load_speed] / ratio_)) / ratio_;
  }
  /// ½ J omega_m² + ½ J_2 omega_2². [J]
  [[nodiscard]] constexpr T kinetic_energy(Values y, T omega_m) const noexcept SEXTANT_NONBLOCKING {
    return T(0.5) * (motor_inertia_ * omega_m * omega_m + inertia_ * y[load_speed] * y[load_speed]);
  }
  /// In the twist of the shaft. [J]
  [[nodiscard]] constexpr T elastic_energy(Values y) const noexcept SEXTANT_NONBLOCKING {
    const T delta = deflection(y);
    return T(0.5) * stiffness_ * delta * delta;
  }
  /// Which flanks touch; neither where there is no gap.
  [[nodiscard]] static constexpr Contact contact(Values y) noexcept SEXTANT_NONBLOCKING {
    if (y[flanks] > T(0.5)) return Contact::ahead;
    return y[flanks] < T(-0.5) ? Contact::behind : Contact::neither;
  }

 private:
  [[nodiscard]] constexpr bool has_gap() const noexcept SEXTANT_NONBLOCKING { return half_gap_ > T(0); }
  [[nodiscard]] constexpr bool is_free(Values y) const noexcept SEXTANT_NONBLOCKING {
    return has_gap() && contact(y) == Contact::neither;
  }
  /// δ [rad]
  [[nodiscard]] constexpr T deflection(Values y) const noexcept SEXTANT_NONBLOCKING {
    return is_free(y) ? T(0) : y[twist] - T(int(contact(y))) * half_gap_;
  }
  /// Of the contact that there is, or without a gap; also where it would pull, so that integrators find
  /// where it ends.
  [[nodiscard]] constexpr T contact_torque(Values y, T omega_m) const noexcept SEXTANT_NONBLOCKING {
    return stiffness_ * deflection(y) + damping_ * (omega_m - y[load_speed]);
  }

  T ratio_;             ///< n [-]
  T motor_inertia_;     ///< J [kg·m²]
  T viscous_friction_;  ///< B [N·m·s/rad]
  RoadLoad<T> road_;    ///< on the load's side of the gear
  T inertia_{};         ///< J_2 with what the road couples, referred [kg·m²]
  T stiffness_{};       ///< c, referred [N·m/rad]
  T damping_{};         ///< d, referred [N·m·s/rad]
  T half_gap_{};        ///< b, referred [rad]
  T tolerance_{};       ///< of the torque of a contact that begins [N·m]
};

}  // namespace sextant
