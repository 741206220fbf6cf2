#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "sextant/core/fault.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/safety/protection_facts.hpp"
#include "sextant/safety/protection_limits.hpp"
#include "sextant/safety/rule_table.hpp"

namespace sextant {

/// One protection. A counter goes up with each usable measurement of which `is_violated` is true and down
/// with each other one; the fault is present while it is at `measurements`. With `duration` it counts the
/// control periods before these measurements, up to those of that time (after the counter-based debouncing of
/// AUTOSAR's Diagnostic Event Manager). A violation that noise interrupts is a fault too, where more than
/// half of the measurements violate the rule.
template <class T = double>
struct ProtectionRule {
  Fault fault{};
  bool (*is_violated)(const ProtectionFacts<T>&, const ProtectionLimits<T>&) noexcept SEXTANT_NONBLOCKING{};
  int measurements{1};                                    ///< [-]
  std::int64_t ProtectionLimits<T>::* duration{nullptr};  ///< takes the place of `measurements` [ns]

  /// Count that makes the fault. [-]
  [[nodiscard]] constexpr int needed(const ProtectionLimits<T>& limits) const noexcept {
    if (duration == nullptr) return measurements;
    return int((limits.*duration + limits.period_ns - 1) / limits.period_ns);
  }
};

namespace protection_rule {

template <class T>
[[nodiscard]] constexpr bool over_current(const ProtectionFacts<T>& facts,
                                          const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.current_peak > limits.over_current;
}

template <class T>
[[nodiscard]] constexpr bool dc_over_voltage(const ProtectionFacts<T>& facts,
                                             const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.measurement.u_dc > limits.dc_over_voltage;
}

/// A link that is not charged yet, with the gates off, is no fault.
template <class T>
[[nodiscard]] constexpr bool dc_under_voltage(
    const ProtectionFacts<T>& facts, const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.is_driven && facts.measurement.u_dc < limits.dc_under_voltage;
}

template <class T>
[[nodiscard]] constexpr bool over_speed(const ProtectionFacts<T>& facts,
                                        const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return std::abs(facts.measurement.omega_m) > limits.over_speed;
}

/// The neutral floats: the currents of three phases add up to zero.
template <class T>
[[nodiscard]] constexpr bool current_sum(const ProtectionFacts<T>& facts,
                                         const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.current_sum > limits.current_sum + limits.current_gain_tolerance * facts.current_peak;
}

/// With the gates off and no current the sensors read something else than zero.
template <class T>
[[nodiscard]] constexpr bool current_has_offset(
    const ProtectionFacts<T>& facts, const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.current_offset > limits.current_offset;
}

/// Magnitude of the reading of phase n. [A]
template <class T>
[[nodiscard]] constexpr T reading(const ProtectionFacts<T>& facts, std::size_t n) noexcept {
  const ThreePhase<T>& i = facts.measurement.i_abc;
  return std::abs(n == 0 ? i.a : n == 1 ? i.b : i.c);
}

/// A phase does not respond and carries no current. With one that is open, voltage along it moves the
/// currents of the others no more than its own.
template <class T>
[[nodiscard]] constexpr bool has_silent_phase(const ProtectionFacts<T>& facts,
                                              const ProtectionLimits<T>& limits) noexcept {
  for (std::size_t n = 0; n < 3; ++n) {
    if ((facts.unresponsive_phases >> n & 1U) != 0 && reading(facts, n) < limits.zero_current) return true;
  }
  return false;
}

/// A jump of a current that no voltage explains. With one phase at zero, or all, it can be the opening of
/// that phase.
template <class T>
[[nodiscard]] constexpr bool current_jumps(const ProtectionFacts<T>& facts,
                                           const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  if (!(facts.response.jump() > limits.current_jump)) return false;
  int at_zero = 0;
  for (std::size_t n = 0; n < 3; ++n) at_zero += reading(facts, n) < limits.zero_current ? 1 : 0;
  return at_zero != 1 && !facts.continuity.all_without_current();
}

/// A converter that has stopped: by the model the currents have changed by half of what counts as a jump,
/// beside what the model may be wrong by. Readings of no current are those of a phase that is open.
template <class T>
[[nodiscard]] constexpr bool currents_stand_still(
    const ProtectionFacts<T>& facts, const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  std::size_t open = CurrentResponse<T>::no_phase;
  for (std::size_t n = 0; n < 3; ++n) open = reading(facts, n) < limits.zero_current ? n : open;
  return facts.current_peak > limits.zero_current &&
         facts.response.hidden_change(open) > T(0.5) * limits.current_jump;
}

/// A sensor that is stuck, or two that are swapped.
template <class T>
[[nodiscard]] constexpr bool current_does_not_respond(
    const ProtectionFacts<T>& facts, const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.unresponsive_phases != 0 && !has_silent_phase(facts, limits);
}

/// A phase without current for so many periods that no ripple explains them, which does not respond, or in
/// which the voltage raises none and nothing shows that it responds: by wrong parameters the voltage that
/// ought to raise a current may be wrong.
template <class T>
[[nodiscard]] bool open_phase(const ProtectionFacts<T>& facts,
                              const ProtectionLimits<T>&) noexcept SEXTANT_NONBLOCKING {
  bool any = false;
  for (std::size_t n = 0; n < 3; ++n) {
    const bool is_unresponsive = (facts.unresponsive_phases >> n & 1U) != 0;
    const bool answers = (facts.answering_phases >> n & 1U) != 0;
    const bool is_open = is_unresponsive || (facts.continuity.is_open(n) && !answers);
    any = any || (facts.continuity.has_no_current(n) && is_open);
  }
  return any;
}

template <class T>
[[nodiscard]] constexpr bool speed_jumps(const ProtectionFacts<T>& facts,
                                         const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.speed_change > limits.speed_jump;
}

template <class T>
[[nodiscard]] constexpr bool speed_disagrees(const ProtectionFacts<T>& facts,
                                             const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.speed.is_off_by(limits.speed_error);
}

template <class T>
[[nodiscard]] constexpr bool direction_is_reversed(
    const ProtectionFacts<T>& facts, const ProtectionLimits<T>& /*limits*/) noexcept SEXTANT_NONBLOCKING {
  return facts.direction.is_reversed();
}

/// Flux that was there and is gone. At zero torque the switching table need not hold it, and a start without
/// MAGNETISING builds it up as the torque allows.
template <class T>
[[nodiscard]] constexpr bool flux_lost(const ProtectionFacts<T>& facts,
                                       const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.flux_was_built && std::abs(facts.drive.torque_reference) > limits.flux_lost_torque &&
         facts.drive.psi_s < limits.flux_lost_share * facts.drive.flux_reference;
}

template <class T>
[[nodiscard]] constexpr bool over_temperature(
    const ProtectionFacts<T>& facts, const ProtectionLimits<T>& limits) noexcept SEXTANT_NONBLOCKING {
  return facts.winding_temperature > limits.winding_trip;
}

}  // namespace protection_rule

/// All protections, in order. Every one is evaluated in every period.
template <class T = double>
inline constexpr std::array protection_rules{
    ProtectionRule<T>{Fault::over_current, protection_rule::over_current<T>},
    ProtectionRule<T>{Fault::dc_over_voltage, protection_rule::dc_over_voltage<T>},
    ProtectionRule<T>{Fault::dc_under_voltage, protection_rule::dc_under_voltage<T>},
    ProtectionRule<T>{Fault::over_speed, protection_rule::over_speed<T>},
    ProtectionRule<T>{Fault::current_sum, protection_rule::current_sum<T>, 3},
    ProtectionRule<T>{Fault::current_sensor, protection_rule::current_has_offset<T>},
    ProtectionRule<T>{Fault::current_sensor, protection_rule::current_jumps<T>, 2},
    ProtectionRule<T>{Fault::current_sensor, protection_rule::currents_stand_still<T>},
    ProtectionRule<T>{Fault::current_sensor, protection_rule::current_does_not_respond<T>},
    ProtectionRule<T>{Fault::open_phase, protection_rule::open_phase<T>},
    ProtectionRule<T>{Fault::speed_sensor, protection_rule::speed_jumps<T>},
    ProtectionRule<T>{Fault::speed_sensor, protection_rule::speed_disagrees<T>, 1,
                      &ProtectionLimits<T>::speed_error_ns},
    ProtectionRule<T>{Fault::speed_sensor, protection_rule::direction_is_reversed<T>},
    ProtectionRule<T>{Fault::flux_lost, protection_rule::flux_lost<T>, 1, &ProtectionLimits<T>::flux_lost_ns},
    ProtectionRule<T>{Fault::over_temperature, protection_rule::over_temperature<T>},
};

}  // namespace sextant
