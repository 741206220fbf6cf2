#pragma once

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/plant_inputs.hpp"
#include "sextant/plant/road_load.hpp"

namespace sextant {

/// The motor's shaft with friction and the road load of a vehicle,
///   domega_m/dt = (tau_e − tau_l − B omega_m − tau_road(omega_m)) / (J + J_road), or the imposed slope
template <class T = double>
class MotorShaft {
 public:
  /// J [kg·m²] and B [N·m·s/rad]; J is above zero.
  MotorShaft(T inertia, T viscous_friction, const RoadLoad<T>& road_load) noexcept
      : inverse_inertia_{T(1) / (inertia + road_load.coupled_inertia)},
        viscous_friction_{viscous_friction},
        road_load_{road_load},
        has_road_load_{road_load.acts()},
        is_loaded_by_road_{has_road_load_} {}

  /// The speed is imposed from outside, or free.
  void impose_speed(bool is_imposed) noexcept SEXTANT_NONBLOCKING {
    is_loaded_by_road_ = has_road_load_ && !is_imposed;
  }

  /// domega_m/dt under a torque of the machine [N·m] and the inputs that act. [rad/s²]
  [[nodiscard]] T acceleration(T tau_e, const PlantInputs<T>& acting,
                               T omega_m) const noexcept SEXTANT_NONBLOCKING {
    T slope = acting.imposed_speed ? acting.speed_slope
                                   : (tau_e - acting.tau_l - viscous_friction_ * omega_m) * inverse_inertia_;
    if (is_loaded_by_road_) [[unlikely]]
      slope -= road_load_.torque(omega_m) * inverse_inertia_;
    return slope;
  }
  /// d²omega_m/dt² of a free shaft by dtau_e/dt [N·m/s] and domega_m/dt [rad/s²]. [rad/s³]
  [[nodiscard]] T curvature(T torque_slope, T omega_m, T acceleration) const noexcept SEXTANT_NONBLOCKING {
    T slope = torque_slope - viscous_friction_ * acceleration;
    if (is_loaded_by_road_) [[unlikely]]
      slope -= road_load_.slope(omega_m) * acceleration;
    return slope * inverse_inertia_;
  }
  /// How a free shaft's domega_m/dt depends on the speed itself. [1/s]
  [[nodiscard]] T slope_by_speed(T omega_m) const noexcept SEXTANT_NONBLOCKING {
    const T friction = -viscous_friction_ * inverse_inertia_;
    return is_loaded_by_road_ ? friction - road_load_.slope(omega_m) * inverse_inertia_ : friction;
  }

  /// tau_road; zero where there is none, or the speed is imposed. [N·m]
  [[nodiscard]] T road_torque(T omega_m) const noexcept SEXTANT_NONBLOCKING {
    return is_loaded_by_road_ ? road_load_.torque(omega_m) : T(0);
  }
  [[nodiscard]] const RoadLoad<T>& road_load() const noexcept SEXTANT_NONBLOCKING { return road_load_; }
  /// 1/(J + J_road). [1/(kg·m²)]
  [[nodiscard]] T inverse_inertia() const noexcept SEXTANT_NONBLOCKING { return inverse_inertia_; }

 private:
  T inverse_inertia_;   ///< [1/(kg·m²)]
  T viscous_friction_;  ///< [N·m·s/rad]
  RoadLoad<T> road_load_;
  bool has_road_load_;      ///< it is not zero
  bool is_loaded_by_road_;  ///< and the speed is not imposed
};

}  // namespace sextant
