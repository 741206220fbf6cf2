#pragma once

#include <cmath>

#include "sextant/core/fault.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/safety/protection_limits.hpp"
#include "sextant/safety/protection_rules.hpp"

namespace sextant {

/// Protections that evaluate one measurement and trip within the control period, by protection_rules.hpp.
template <class T = double>
class Protection {
 public:
  using Parameters = ProtectionLimits<T>;

  constexpr explicit Protection(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// True for a plausible measurement in which every number is finite.
  [[nodiscard]] static bool is_usable(const Measurement<T>& m) noexcept {
    return m.plausible && std::isfinite(m.i_abc.a) && std::isfinite(m.i_abc.b) && std::isfinite(m.i_abc.c) &&
           std::isfinite(m.u_dc) && std::isfinite(m.omega_m) && std::isfinite(m.theta_m.value_or(T(0)));
  }

  /// The faults of this measurement; `measurement_invalid`, and no other, when it is not usable.
  [[nodiscard]] FaultSet step(const Measurement<T>& m) const noexcept {
    if (is_usable(m)) return evaluate<protection_rules<T>>(m, parameters_);
    FaultSet faults;
    faults.set(Fault::measurement_invalid);
    return faults;
  }

 private:
  Parameters parameters_;
};

}  // namespace sextant
