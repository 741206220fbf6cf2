#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>

#include "sextant/core/fault.hpp"
#include "sextant/core/inverter_model.hpp"
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
/// the facts. The monitors integrate over the time for which the applied pattern acted: none where a reading
/// is repeated, several periods where several were missed. They leave out, begin anew and count an interval
/// in which legs were driven for a part of the time only, or in which the rotor turned by a quarter of an
/// electrical turn or more, which their models do not follow.
template <class T = double>
class Protection {
 public:
  using Parameters = ProtectionLimits<T>;

  explicit Protection(const Parameters& parameters) noexcept
      : limits_{parameters},
        offset_{{.limit = parameters.current_offset,
                 .noise = parameters.current_noise,
                 .step = parameters.current_step}},
        inverter_{parameters.inverter, parameters.machine.sigma_l_s()},
        prediction_{parameters.machine, parameters.inverter, parameters.period_ns},
        response_{{.period_ns = parameters.period_ns,
                   .jump = parameters.current_jump,
                   .step = parameters.current_step}},
        continuity_{{.zero_current = parameters.zero_current + parameters.current_step,
                     .noise = T(6) * parameters.current_noise + parameters.current_step,
                     .response = parameters.current_response}},
        noise_{noise(parameters)},
        speed_{{.machine = parameters.machine,
                .period_ns = parameters.period_ns,
                .voltage_error = parameters.inverter.voltage_error}},
        direction_{direction_check(parameters)},
        winding_{parameters.winding},
        share_per_kelvin_{T(1) / (parameters.winding_trip - parameters.winding_warning)},
        quarter_turn_{T(std::numbers::pi / 2) / T(parameters.machine.pole_pairs)} {
    for (std::size_t n = 0; n < rule_count; ++n) needed_[n] = protection_rules<T>[n].needed(parameters);
  }

  /// True for a plausible measurement of which every number is one that its sensor can read.
  [[nodiscard]] bool is_usable(const Measurement<T>& m) const noexcept {
    const auto within = [](T x, T range) { return std::abs(x) <= range; };  // false for NaN
    const T current = limits_.current_range;
    return m.plausible && within(m.i_abc.a, current) && within(m.i_abc.b, current) &&
           within(m.i_abc.c, current) && within(m.u_dc, limits_.voltage_range) &&
           within(m.omega_m, limits_.speed_range) && std::isfinite(m.theta_m.value_or(T(0))) &&
           is_of_a_winding(m.winding_temperature.value_or(T(0)));
  }

  /// A temperature that a winding may have, and no shorted or open sensor: from −60 to 300 °C. False for NaN.
  [[nodiscard]] static constexpr bool is_of_a_winding(T celsius) noexcept {
    return celsius >= T(-60) && celsius <= T(300);
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
    const ProtectionFacts<T> facts{.measurement = m,
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
                                   .speed_change = is_driven ? speed_change(m) : T(0),
                                   .winding_temperature = winding_.temperature()};
    evaluate(facts, periods_of(m.applied), faults);
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

  /// Takes the limits of another one for the same machine, inverter and period; the monitors, the counts of
  /// violations and the winding's temperature stay.
  void take_parameters(const Protection& from) noexcept {
    limits_ = from.limits_;
    offset_.take_parameters(from.offset_);
    response_.take_parameters(from.response_);
    continuity_.take_parameters(from.continuity_);
    direction_.take_parameters(from.direction_);
    winding_.take_parameters(from.winding_);
    noise_ = from.noise_;
    share_per_kelvin_ = from.share_per_kelvin_;
    needed_ = from.needed_;
    for (std::size_t n = 0; n < rule_count; ++n) counts_[n] = std::min(counts_[n], needed_[n]);
  }

  /// Goes on after one of another machine or inverter: takes over what is known of sensors and winding.
  void continue_after(const Protection& before) noexcept {
    const Protection own{*this};
    offset_ = before.offset_;
    offset_.take_parameters(own.offset_);
    winding_ = before.winding_;
    winding_.take_parameters(own.winding_);
    unchecked_periods_ = before.unchecked_periods_;
    omega_m_ = before.omega_m_;
  }

  /// Control periods since the start that the checks of currents and speed left out while legs were driven.
  /// [-]
  [[nodiscard]] constexpr std::uint64_t unchecked_periods() const noexcept { return unchecked_periods_; }

  /// Measured or by the model; empty without either. [°C]
  [[nodiscard]] std::optional<T> winding_temperature() const noexcept {
    return winding_.is_known() ? std::optional<T>{winding_.temperature()} : std::nullopt;
  }

  /// Share of the torque that the winding's temperature leaves: 1 up to the warning, 0 at the trip. [-]
  [[nodiscard]] T available_share() const noexcept {
    return std::clamp((limits_.winding_trip - winding_.temperature()) * share_per_kelvin_, T(0), T(1));
  }

 private:
  /// Of the speed trip, which is 3.5 times base speed by default: below 0.2 % of base speed an encoder counts
  /// too few edges for a direction. [-]
  static constexpr T slowest_share = T(0.0005);
  static constexpr std::size_t rule_count = protection_rules<T>.size();

  [[nodiscard]] static DirectionCheck<T> direction_check(const Parameters& p) noexcept {
    return DirectionCheck<T>{
        {.machine = p.machine, .current_noise = p.current_noise, .slowest = slowest_share * p.over_speed}};
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

  /// Control periods for which a pattern acted, to the nearest, one at least; zero where a reading is
  /// repeated. [-]
  [[nodiscard]] constexpr int periods_of(const GatePattern& applied) const noexcept {
    const std::int64_t duration_ns = applied.duration_ns();
    if (duration_ns == limits_.period_ns || applied.segments().empty()) return 1;
    if (duration_ns == 0) return 0;
    const std::int64_t periods = (duration_ns + limits_.period_ns / 2) / limits_.period_ns;
    return int(std::clamp<std::int64_t>(periods, 1, std::numeric_limits<int>::max() / 2));
  }

  /// Magnitude of the change of the speed a control period. [rad/s]
  [[nodiscard]] T speed_change(const Measurement<T>& m) const noexcept {
    const T change = std::abs(m.omega_m - omega_m_.value_or(m.omega_m));
    return change / T(std::max(1, periods_of(m.applied)));
  }

  /// True where every leg was driven since the last measurement.
  [[nodiscard]] bool update_monitors(const Measurement<T>& m, const ProtectionInputs<T>& drive) noexcept {
    // An empty pattern, gates off, tells no time.
    const std::int64_t duration_ns =
        m.applied.segments().empty() ? limits_.period_ns : m.applied.duration_ns();
    offset_.step(m);
    // The sign of a small current is that without its offset.
    const ThreePhase<T> beyond = inverter_.step(m.applied, without_offset(m).i_abc, m.u_dc);
    winding_.step(within_trip(m.i_abc), duration_ns, m.winding_temperature);
    if (!m.applied.is_driven()) {
      leave_out(m, drive.psi_r);
      direction_.restart();
      direction_.step_without_voltage(m.i_abc, m.omega_m, seconds(duration_ns));
      return false;
    }
    if (duration_ns == 0) return true;  // a reading that is repeated
    if (!(std::abs(m.omega_m) * seconds(duration_ns) < quarter_turn_)) {
      leave_out(m, drive.psi_r);
      direction_.step_without_voltage(m.i_abc, m.omega_m, seconds(duration_ns));
      return true;
    }
    check(m, applied_volt_seconds(m.applied, m.u_dc, beyond), drive, duration_ns);
    return true;
  }

  /// The monitors' step over an interval in which every leg was driven. [V·s], [ns]
  void check(const Measurement<T>& m, const ThreePhase<T>& volt_seconds, const ProtectionInputs<T>& drive,
             std::int64_t duration_ns) noexcept {
    const T dt = seconds(duration_ns);
    const bool is_one = duration_ns == limits_.period_ns;
    const PredictedChange<T> change = prediction_.step(
        m.i_abc, {drive.psi_r, drive.psi_r_error, T(limits_.machine.pole_pairs) * m.omega_m * dt},
        volt_seconds, m.u_dc, dt);
    response_.step(m.i_abc, change, is_one ? T(1) : T(duration_ns) / T(limits_.period_ns));
    continuity_.step(m.i_abc, change);
    speed_.step(m.i_abc, volt_seconds, m.omega_m, drive.torque, drive.psi_s, drive.flux_reference,
                duration_ns);
    direction_.step(m.i_abc, volt_seconds, m.u_dc, m.omega_m, dt);
  }

  void leave_out(const Measurement<T>& m, SpaceVector<T> psi_r) noexcept {
    restart(m.i_abc, psi_r);
    for (const GateSegment& segment : m.applied.segments()) {
      if (segment.state == gates_off || segment.duration_ns == 0) continue;
      unchecked_periods_ += std::uint64_t(periods_of(m.applied));
      return;
    }
  }

  void restart(const ThreePhase<T>& i, SpaceVector<T> psi_r) noexcept {
    prediction_.restart(i, psi_r);
    response_.restart(i);
    continuity_.restart();
    speed_.restart(i);
  }

  [[nodiscard]] static constexpr T seconds(std::int64_t ns) noexcept { return T(ns) * T(1e-9); }

  /// `periods`: control periods since the measurement before; none: it is repeated, and counts no more.
  void evaluate(const ProtectionFacts<T>& facts, int periods, FaultSet& faults) noexcept {
    for_each_rule<protection_rules<T>>([&]<std::size_t n>() {
      constexpr const ProtectionRule<T>& rule = protection_rules<T>[n];
      const bool violated = rule.is_violated(facts, limits_);
      if constexpr (rule.measurements == 1 && rule.duration == nullptr) {
        if (violated) faults.set(rule.fault);
      } else {
        const int step = rule.duration == nullptr ? std::min(periods, 1) : std::min(periods, needed_[n]);
        counts_[n] = violated ? std::min(counts_[n] + step, needed_[n]) : std::max(counts_[n] - step, 0);
        if (counts_[n] == needed_[n]) faults.set(rule.fault);
      }
    });
  }

  Parameters limits_;
  CurrentOffset<T> offset_;
  InverterModel<T> inverter_;
  CurrentPrediction<T> prediction_;
  CurrentResponse<T> response_;
  PhaseContinuity<T> continuity_;
  T noise_;  ///< variance of a reading of a phase current [A²]
  SpeedPlausibility<T> speed_;
  DirectionCheck<T> direction_;
  WindingTemperature<T> winding_;
  T share_per_kelvin_;
  T quarter_turn_;  ///< of the rotor, electrical, as a mechanical angle [rad]
  std::uint64_t unchecked_periods_{0};
  std::array<int, rule_count> needed_{};  ///< count that makes a fault, by rule [-]
  std::array<int, rule_count>
      counts_{};  ///< measurements that violated the rule less those after that did not [-]
  bool flux_was_built_{false};
  std::optional<T> omega_m_{};  ///< of the last usable measurement [rad/s]
};

}  // namespace sextant
