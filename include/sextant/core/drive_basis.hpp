#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/inverter_model.hpp"
#include "sextant/core/iron_torque.hpp"
#include "sextant/core/saturation_parameters.hpp"

namespace sextant {

/// What controller, protections and limits of a drive have in common, stated once.
template <class T = double>
struct DriveBasis {
  InductionMachineParameters<T> machine{};  ///< as the drive takes it to be
  SaturationParameters<T> saturation{};     ///< the same, of its main flux; none by default
  /// The same, R_fe of its iron loss, per phase (`iron_torque`); infinite: none; in a `DriveSetup` that of
  /// `optimal_flux` takes its place [Ω]
  T iron_loss_resistance{no_iron_loss<T>};
  typename InverterModel<T>::Parameters inverter{};  ///< the same, what makes the voltage of the patterns
  std::int32_t period_ns{25'000};                    ///< control period [ns]
  std::int32_t sampling_lead_ns{0};  ///< from the sample of the currents to the control period [ns]
  int actuation_delay_periods{0};    ///< 1: a pattern is applied one period after its decision [-]
  T u_dc{T(530)};                    ///< nominal voltage of the DC link [V]
  T flux_reference{T(1.1)};          ///< stator flux linkage at a flux share of 1 [Wb]

  [[nodiscard]] const char* validate() const noexcept {
    const auto positive = [](T x) { return std::isfinite(x) && x > T(0); };
    if (period_ns <= 0) return "the control period must be above zero";
    if (sampling_lead_ns < 0 || sampling_lead_ns > period_ns) {
      return "the sampling lead must be from zero to the control period";
    }
    if (actuation_delay_periods < 0 || actuation_delay_periods > 1) {
      return "the actuation delay must be 0 or 1 periods";
    }
    if (!positive(u_dc)) return "the voltage of the DC link must be above zero";
    if (!positive(flux_reference)) return "the flux reference must be above zero";
    if (const char* problem = machine.validate()) return problem;
    if (const char* problem = saturation.validate()) return problem;
    if (!(iron_loss_resistance > T(0))) return "the resistance of the iron loss must be above zero";
    return inverter.validate(period_ns);
  }
};

}  // namespace sextant
