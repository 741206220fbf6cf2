#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/core/fault.hpp"
#include "sextant/core/measurement.hpp"

namespace sextant {

/// Protections that judge one measurement: they trip within the control period.
template <class T = double>
class Protection {
 public:
  struct Parameters {
    T over_current{T(200)};     ///< trip level of any phase current's magnitude [A]
    T dc_over_voltage{T(700)};  ///< trip level of the DC link [V]
    T over_speed{T(167)};       ///< trip level of the mechanical speed's magnitude [rad/s]

    [[nodiscard]] const char* validate() const noexcept {
      if (!(std::isfinite(over_current) && over_current > T(0))) return "the current trip must be above zero";
      if (!(std::isfinite(dc_over_voltage) && dc_over_voltage > T(0))) {
        return "the DC-link voltage trip must be above zero";
      }
      if (!(std::isfinite(over_speed) && over_speed > T(0))) return "the speed trip must be above zero";
      return nullptr;
    }
  };

  constexpr explicit Protection(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// True when every number is finite and the power stage vouches for them: a controller may use them.
  [[nodiscard]] static bool is_usable(const Measurement<T>& m) noexcept {
    return m.plausible && std::isfinite(m.i_abc.a) && std::isfinite(m.i_abc.b) && std::isfinite(m.i_abc.c) &&
           std::isfinite(m.u_dc) && std::isfinite(m.omega_m);
  }

  /// The faults that this measurement shows; `measurement_invalid` when it is not usable.
  [[nodiscard]] FaultSet step(const Measurement<T>& m) const noexcept {
    FaultSet faults;
    if (!is_usable(m)) {
      faults.set(Fault::measurement_invalid);
      return faults;
    }
    const T peak = std::max({std::abs(m.i_abc.a), std::abs(m.i_abc.b), std::abs(m.i_abc.c)});
    if (peak > parameters_.over_current) faults.set(Fault::over_current);
    if (m.u_dc > parameters_.dc_over_voltage) faults.set(Fault::dc_over_voltage);
    if (std::abs(m.omega_m) > parameters_.over_speed) faults.set(Fault::over_speed);
    return faults;
  }

 private:
  Parameters parameters_;
};

}  // namespace sextant
