#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "sextant/core/fault.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/safety/protection_limits.hpp"
#include "sextant/safety/rule_table.hpp"

namespace sextant {

/// One protection: the fault is present while `is_violated` is true of a usable measurement.
template <class T = double>
struct ProtectionRule {
  Fault fault{};
  bool (*is_violated)(const Measurement<T>&, const ProtectionLimits<T>&) noexcept SEXTANT_NONBLOCKING{};
};

namespace protection_rule {

template <class T>
[[nodiscard]] constexpr bool over_current(const Measurement<T>& m,
                                          const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return std::max({std::abs(m.i_abc.a), std::abs(m.i_abc.b), std::abs(m.i_abc.c)}) > limits.over_current;
}

template <class T>
[[nodiscard]] constexpr bool dc_over_voltage(const Measurement<T>& m,
                                             const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return m.u_dc > limits.dc_over_voltage;
}

template <class T>
[[nodiscard]] constexpr bool over_speed(const Measurement<T>& m,
                                        const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return std::abs(m.omega_m) > limits.over_speed;
}

}  // namespace protection_rule

/// All protections that evaluate one measurement, in order.
template <class T = double>
inline constexpr std::array protection_rules{
    ProtectionRule<T>{Fault::over_current, protection_rule::over_current<T>},
    ProtectionRule<T>{Fault::dc_over_voltage, protection_rule::dc_over_voltage<T>},
    ProtectionRule<T>{Fault::over_speed, protection_rule::over_speed<T>},
};

/// Evaluates every rule of the table, in order; the faults of those that are violated.
template <const auto& rules, class T>
[[nodiscard]] constexpr FaultSet evaluate(const Measurement<T>& m,
                                          const ProtectionLimits<T>& limits) noexcept {
  FaultSet faults;
  for_each_rule<rules>([&]<std::size_t n>() {
    if (rules[n].is_violated(m, limits)) faults.set(rules[n].fault);
  });
  return faults;
}

}  // namespace sextant
