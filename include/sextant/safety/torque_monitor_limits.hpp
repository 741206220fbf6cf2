#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/inverter_model.hpp"
#include "sextant/core/iron_torque.hpp"
#include "sextant/core/saturation_parameters.hpp"

namespace sextant {

/// Limits of the torque monitor, and the errors of parameters and sensors that it allows for. A share s of a
/// machine parameter says that the value in `machine` is between 1 − s and 1 + s times the true one; of R_s,
/// which the winding's temperature changes, also that the true one is not below 1 − s times that in
/// `machine`.
template <class T = double>
struct TorqueMonitorLimits {
  bool enabled{true};                       ///< false: no fault; the torque is estimated all the same
  InductionMachineParameters<T> machine{};  ///< the monitor's own parameters of the machine
  SaturationParameters<T> saturation{};     ///< the same, of its main flux; none by default
  typename InverterModel<T>::Parameters inverter{};  ///< the drive's, checked with its control period
  T iron_loss_resistance{no_iron_loss<T>};           ///< the drive's; infinite: none [Ω]
  T flux_reference{T(1.1)};           ///< below half of it growing flux excuses a lack of torque [Wb]
  T limit{T(10)};                     ///< smallest deviation that counts [N·m]
  T limit_share{T(0.05)};             ///< the same as a share of the command [-]
  T wrong_sign{T(5)};                 ///< smallest torque against the command's sign that counts [N·m]
  std::int64_t time_ns{10'000'000};   ///< a deviation is a fault after this time at the latest [ns]
  std::int64_t window_ns{1'000'000};  ///< averaging time of torque and command [ns]
  T r_s_share{T(0.5)};                ///< error of R_s [-]
  T r_r_share{T(0.5)};                ///< error of R_r [-]
  T l_m_share{T(0.3)};                ///< error of L_m [-]
  T sensor_share{T(0.05)};            ///< relative error of the torque by the gains of the sensors [-]
  T current_offset{T(0.77)};          ///< largest offset of the current vector: 4/3 of that of a phase [A]

  [[nodiscard]] const char* validate() const noexcept {
    const auto positive = [](T x) { return std::isfinite(x) && x > T(0); };
    const auto is_share = [](T x) { return x >= T(0) && x < T(1); };
    if (const char* problem = machine.validate()) return problem;
    if (const char* problem = saturation.validate()) return problem;
    if (!(iron_loss_resistance > T(0))) return "the resistance of the iron loss must be above zero";
    if (!positive(flux_reference)) return "the flux reference must be above zero";
    if (!positive(limit) || !positive(wrong_sign)) return "the torque deviations must be above zero";
    if (!is_share(limit_share)) return "the share of the command must be in [0, 1)";
    if (window_ns <= 0) return "the averaging time must be above zero";
    if (time_ns < 2 * window_ns) return "a fault must take at least two averaging times";
    if (!is_share(r_s_share) || !is_share(r_r_share) || !is_share(l_m_share) || !is_share(sensor_share)) {
      return "the errors of parameters and sensors must be in [0, 1)";
    }
    if (!(std::isfinite(current_offset) && current_offset >= T(0))) {
      return "the offset of the current must not be below zero";
    }
    return nullptr;
  }
};

}  // namespace sextant
