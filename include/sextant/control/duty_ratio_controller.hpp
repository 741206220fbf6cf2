#pragma once

#include <algorithm>
#include <cstddef>

#include "sextant/control/flux_vector_controller.hpp"
#include "sextant/core/two_level_inverter.hpp"

namespace sextant {

/// Direct torque control with a duty ratio: one active vector V_n a period, for the share d of it, between
/// two halves of a zero vector,
///   d = u · V_n/|V_n|²,   n: the largest u · V_n
/// with which d V_n is, of all mean voltages with one active vector, nearest to the voltage u that leads
/// torque and stator flux to their references. Sources: J.-K. Kang, S.-K. Sul, "New direct torque control of
/// induction motor for minimum torque ripple and constant switching frequency", IEEE Trans. Ind. Appl. 35
/// (1999) 1076–1082; Y. Zhang, H. Yang, "Model predictive torque control of induction motor drives with
/// optimal duty cycle control", IEEE Trans. Power Electron. 29 (2014) 6593–6603.
template <class T = double>
class DutyRatioController final : public FluxVectorController<T> {
 public:
  static constexpr const char* name = "duty_ratio";
  static constexpr const char* meaning = "torque control by one active and one zero vector a period";

  struct Parameters : FluxVectorController<T>::Parameters {};

  explicit DutyRatioController(const Parameters& parameters) noexcept : Base{parameters} {}

 private:
  using Base = FluxVectorController<T>;

  [[nodiscard]] GatePattern realise(SpaceVector<T> u, T u_dc, T) noexcept SEXTANT_NONBLOCKING override {
    std::size_t nearest = 1;
    T projection{};  // u · V_n [V²]
    for (std::size_t n = 1; n <= 6; ++n) {
      const T candidate = dot(u, stator_voltage(switch_states[n], u_dc));
      if (!(candidate > projection)) continue;
      projection = candidate;
      nearest = n;
    }
    const SwitchState active = switch_states[nearest];
    const SpaceVector<T> v = stator_voltage(active, u_dc);
    const T square = dot(v, v);
    return Base::pulse(active, projection > T(0) ? std::min(projection / square, T(1)) : T(0), v);
  }
};

}  // namespace sextant
