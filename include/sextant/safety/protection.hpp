#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "sextant/core/fault.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/safety/applied_volt_seconds.hpp"
#include "sextant/safety/current_offset.hpp"
#include "sextant/safety/current_prediction.hpp"
#include "sextant/safety/current_response.hpp"
#include "sextant/safety/direction_check.hpp"
#include "sextant/safety/phase_continuity.hpp"
#include "sextant/safety/protection_facts.hpp"
#include "sextant/safety/protection_limits.hpp"
#include "sextant/safety/protection_rules.hpp"
#include "sextant/safety/speed_plausibility.hpp"
#include "sextant/safety/winding_temperature.hpp"

namespace sextant {

/// The protections by measurements: monitors turn them into facts once a period, protection_rules.hpp limits
/// the facts.
template <class T = double>
class Protection {
 public:
  using Parameters = ProtectionLimits<T>;

  explicit Protection(const Parameters& parameters) noexcept
      : limits_{parameters},
        offset_{{.limit = parameters.current_offset,
                 .noise = parameters.current_noise,
                 .step = parameters.current_step}},
        prediction_{parameters.machine, parameters.period_ns},
        response_{{.period_ns = parameters.period_ns,
                   .jump = parameters.current_jump,
                   .step = parameters.current_step}},
        continuity_{{.zero_current = parameters.zero_current + parameters.current_step,
                     .response = parameters.current_response}},
        noise_{noise(parameters)},
        speed_{{.machine = parameters.machine, .period_ns = parameters.period_ns}},
        direction_{direction_check(parameters)},
        winding_{with_period(parameters.winding, parameters.period_ns)},
        share_per_kelvin_{T(1) / (parameters.winding_trip - parameters.winding_warning)} {
    for (std::size_t n = 0; n < rule_count; ++n) needed_[n] = protection_rules<T>[n].needed(parameters);
  }

  /// True for a plausible measurement of which every number is one that its sensor can read.
  [[nodiscard]] bool is_usable(const Measurement<T>& m) const noexcept {
    const auto within = [](T x, T range) { return std::abs(x) <= range; };  // false for NaN
    const T current = limits_.current_range;
    return m.plausible && within(m.i_abc.a, current) && within(m.i_abc.b, current) &&
           within(m.i_abc.c, current) && within(m.u_dc, limits_.voltage_range) &&
           within(m.omega_m, limits_.speed_range) && std::isfinite(m.theta_m.value_or(T(0)));
  }

  /// The faults that the measurements up to this one show; `measurement_invalid`, and no other, where it is
  /// not usable, and the monitors start anew.
  [[nodiscard]] FaultSet step(const Measurement<T>& m, const ProtectionInputs<T>& drive = {}) noexcept {
    FaultSet faults;
    if (!is_usable(m)) {
      faults.set(Fault::measurement_invalid);
      restart({}, drive.psi_r);
      direction_.coast(seconds(limits_.period_ns));
      counts_ = {};
      omega_m_.reset();
      return faults;
    }
    const bool is_driven = update_monitors(m, drive);
    flux_was_built_ = drive.makes_torque && (flux_was_built_ || drive.psi_s > T(0.8) * drive.flux_reference);
    const ThreePhase<T>& i = m.i_abc;
    const ProtectionFacts<T> facts{
        .measurement = m,
        .drive = drive,
        .response = response_,
        .continuity = continuity_,
        .speed = speed_,
        .direction = direction_,
        .is_driven = is_driven,
        .flux_was_built = flux_was_built_,
        .unresponsive_phases = unresponsive_phases(),
        .answering_phases = answering_phases(),
        .current_peak = std::max({std::abs(i.a), std::abs(i.b), std::abs(i.c)}),
        .current_sum = std::abs(i.a + i.b + i.c),
        .current_offset = offset_.largest(),
        .speed_change = is_driven ? std::abs(m.omega_m - omega_m_.value_or(m.omega_m)) : T(0),
        .winding_temperature = winding_.temperature()};
    evaluate(facts, faults);
    omega_m_ = m.omega_m;
    return faults;
  }

  /// A usable measurement without the offset of its currents, for the controller: the protections evaluate
  /// the readings themselves.
  [[nodiscard]] Measurement<T> without_offset(const Measurement<T>& m) const noexcept {
    return offset_.removed_from(m);
  }

  /// A fault is over: its readings are not to stay in what is kept of the currents.
  void leave_fault() noexcept {
    offset_.restart();
    direction_ = direction_check(limits_);
  }

  /// Share of the torque that the winding's temperature leaves: 1 up to the warning, 0 at the trip. [-]
  [[nodiscard]] T available_share() const noexcept {
    return std::clamp((limits_.winding_trip - winding_.temperature()) * share_per_kelvin_, T(0), T(1));
  }

 private:
  /// Of the speed trip, which is 3.5 times base speed by default: below 0.5 % of base speed an encoder counts
  /// too few edges for a direction. [-]
  static constexpr T slowest_share = T(0.0005);
  static constexpr std::size_t rule_count = protection_rules<T>.size();

  [[nodiscard]] static DirectionCheck<T> direction_check(const Parameters& p) noexcept {
    return DirectionCheck<T>{
        {.machine = p.machine, .current_noise = p.current_noise, .slowest = slowest_share * p.over_speed}};
  }

  [[nodiscard]] static typename WindingTemperature<T>::Parameters with_period(
      typename WindingTemperature<T>::Parameters p, std::int32_t period_ns) noexcept {
    p.period_ns = period_ns;
    return p;
  }

  /// A current beyond the trip level does not flow for long; its reading may be that of a broken sensor.
  [[nodiscard]] ThreePhase<T> within_trip(const ThreePhase<T>& i) const noexcept {
    const T most = limits_.over_current;
    return {std::clamp(i.a, -most, most), std::clamp(i.b, -most, most), std::clamp(i.c, -most, most)};
  }

  /// Variance of a reading; a converter's step q makes q²/12 of it. [A²]
  [[nodiscard]] static constexpr T noise(const Parameters& p) noexcept {
    return p.current_noise * p.current_noise + p.current_step * p.current_step / T(12);
  }

  [[nodiscard]] unsigned unresponsive_phases() const noexcept {
    unsigned phases = 0;
    for (std::size_t n = 0; n < 3; ++n) {
      phases |= response_.is_unresponsive(n, limits_.current_response, noise_) ? 1U << n : 0U;
    }
    return phases;
  }

  [[nodiscard]] unsigned answering_phases() const noexcept {
    unsigned phases = 0;
    for (std::size_t n = 0; n < 3; ++n) {
      phases |= response_.answers(n, limits_.current_response, noise_) ? 1U << n : 0U;
    }
    return phases;
  }

  /// True where every leg was driven since the last measurement.
  [[nodiscard]] bool update_monitors(const Measurement<T>& m, const ProtectionInputs<T>& drive) noexcept {
    offset_.step(m);
    winding_.step(within_trip(m.i_abc));
    if (!m.applied.is_driven()) {
      restart(m.i_abc, drive.psi_r);
      direction_.restart();
      direction_.step_without_voltage(m.i_abc, m.omega_m, seconds(m.applied.duration_ns()));
      return false;
    }
    const AppliedVoltSeconds<T> applied = applied_volt_seconds(m.applied, m.u_dc);
    if (applied.duration_ns != limits_.period_ns) {
      restart(m.i_abc, drive.psi_r);  // periods were missed
      direction_.step_without_voltage(m.i_abc, m.omega_m, seconds(applied.duration_ns));
      return true;
    }
    const PredictedChange<T> change = prediction_.step(m.i_abc, drive.psi_r, applied.integral, m.u_dc);
    response_.step(m.i_abc, change);
    continuity_.step(m.i_abc, change);
    speed_.step(m.i_abc, applied.integral, m.omega_m, drive.torque, drive.psi_s, drive.flux_reference);
    direction_.step(m.i_abc, applied.integral, m.u_dc, m.omega_m, seconds(applied.duration_ns));
    return true;
  }

  void restart(const ThreePhase<T>& i, SpaceVector<T> psi_r) noexcept {
    prediction_.restart(i, psi_r);
    response_.restart(i);
    continuity_.restart();
    speed_.restart(i);
  }

  [[nodiscard]] static constexpr T seconds(std::int64_t ns) noexcept { return T(ns) * T(1e-9); }

  void evaluate(const ProtectionFacts<T>& facts, FaultSet& faults) noexcept {
    for_each_rule<protection_rules<T>>([&]<std::size_t n>() {
      constexpr const ProtectionRule<T>& rule = protection_rules<T>[n];
      const bool violated = rule.is_violated(facts, limits_);
      if constexpr (rule.measurements == 1 && rule.duration == nullptr) {
        if (violated) faults.set(rule.fault);
      } else {
        counts_[n] = violated ? std::min(counts_[n] + 1, needed_[n]) : std::max(counts_[n] - 1, 0);
        if (counts_[n] == needed_[n]) faults.set(rule.fault);
      }
    });
  }

  Parameters limits_;
  CurrentOffset<T> offset_;
  CurrentPrediction<T> prediction_;
  CurrentResponse<T> response_;
  PhaseContinuity<T> continuity_;
  T noise_;  ///< variance of a reading of a phase current [A²]
  SpeedPlausibility<T> speed_;
  DirectionCheck<T> direction_;
  WindingTemperature<T> winding_;
  T share_per_kelvin_;
  std::array<int, rule_count> needed_{};  ///< count that makes a fault, by rule [-]
  std::array<int, rule_count>
      counts_{};  ///< measurements that violated the rule less those after that did not [-]
  bool flux_was_built_{false};
  std::optional<T> omega_m_{};  ///< of the last usable measurement [rad/s]
};

}  // namespace sextant
