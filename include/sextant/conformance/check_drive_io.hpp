#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sextant/conformance/conformance_result.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/measurement.hpp"

namespace sextant {

struct DriveIoConformanceParameters {
  std::int32_t period_ns{25'000};  ///< control period [ns]
  int actuation_delay_periods{0};  ///< `drive.actuation_delay_periods` of this power stage, 0 or 1 [-]
  int start_periods{100};          ///< within which the measurement becomes plausible, gates off [-]
  int silent_periods{10};          ///< without a call, after which the gates are off [-]
  std::int32_t resolution_ns{0};   ///< of the edges in the applied pattern [ns]
  bool has_machine{true};          ///< a machine at standstill is connected; false: no rule on currents
  std::int64_t begin_ns{0};        ///< time of the first read is a period later [ns]
  /// Returns when it is that time [ns]: of a clock for hardware, or what moves a plant. Empty: at once.
  std::function<void(std::int64_t)> wait{};
};

/// Plays a drive to a power stage and checks what a drive relies on (docs/hil.md):
///
///   plausible   the measurement becomes plausible with the gates off, and stays so while every period
///               has its pattern
///   finite      values of a plausible measurement are finite, the angle is within [−π, π]
///   duration    the applied pattern fills the time since the last read, also over missed periods, without
///               segments below zero; or the measurement is not plausible
///   applied     the applied pattern is the one of its period, by the actuation delay: states and durations
///   off         after gates off, or an empty pattern, no leg is driven
///   silence     without a new pattern the gates go off by themselves, or the measurement is not plausible
///   currents    V1, V3 and V5 raise the current of leg a, b and c, and lower the other two; the sum of
///               the currents stays zero
///
/// A single vector lasts for one period, with the gates off before and after; then each vector is followed by
/// its opposite. At standstill the current so stays near that of one period, u_dc·2/3 t_period/σL_s. It
/// allocates, so that it belongs into tests.
template <class T = double>
class DriveIoCheck {
 public:
  /// The power stage must outlive the check.
  DriveIoCheck(DriveIo<T>& io, DriveIoConformanceParameters parameters)
      : io_{io}, p_{std::move(parameters)}, t_ns_{p_.begin_ns} {}

  [[nodiscard]] ConformanceResult run() {
    if (!start("plausible: the measurement does not become plausible with the gates off")) return result_;
    follow_patterns();
    miss_periods();
    fall_silent();
    return result_;
  }

 private:
  using Measured = Measurement<T>;

  /// Gates off until the measurement has been plausible for some periods.
  bool start(const char* sentence) {
    int plausible = 0;
    written_.clear();
    for (int k = 0; k < p_.start_periods && plausible < settled(); ++k)
      plausible = period(off()).plausible ? plausible + 1 : 0;
    require(plausible == settled(), sentence);
    return plausible == settled();
  }

  /// Periods after which a pattern has been applied and measured. [-]
  [[nodiscard]] int settled() const { return 2 + p_.actuation_delay_periods; }
  [[nodiscard]] GatePattern off() const { return {gates_off, p_.period_ns}; }

  void follow_patterns() {
    is_regular_ = true;
    for (const std::size_t vector : {1U, 4U, 2U, 5U, 3U, 6U, 0U, 7U})
      pulse({switch_states[vector], p_.period_ns}, off());
    for (const std::size_t most : {std::size_t{7}, GatePattern::capacity}) pulse(mixed(most), GatePattern{});
    for (const std::size_t vector : {1U, 4U, 2U, 5U, 3U, 6U})
      (void)period({switch_states[vector], p_.period_ns});
    rest(off());
    is_regular_ = false;
  }

  /// Active vectors and their opposites in turn, in a period.
  [[nodiscard]] GatePattern mixed(std::size_t segments) const {
    constexpr std::array<std::size_t, GatePattern::capacity> vectors{0, 1, 4, 2, 7, 5, 3, 6};
    const std::int32_t part_ns = p_.period_ns / std::int32_t(segments);
    GatePattern pattern;
    for (std::size_t k = 0; k + 1 < segments; ++k) pattern.append({switch_states[vectors[k]], part_ns});
    pattern.append({switch_states[vectors[segments - 1]],
                    std::int32_t(p_.period_ns - std::int64_t(segments - 1) * part_ns)});
    return pattern;
  }

  /// A pattern for one period, then the gates off as `after` says.
  void pulse(const GatePattern& pattern, const GatePattern& after) {
    const std::array<T, 3> before = currents(period(pattern));
    for (int k = 0; k < p_.actuation_delay_periods; ++k) (void)period(after);
    check_rise(pattern, before, currents(period(after)));
    rest(after);
  }
  void rest(const GatePattern& pattern) {
    for (int k = 0; k < 2 * settled(); ++k) (void)period(pattern);
  }

  void miss_periods() {
    (void)after_pause(3);
    (void)start("plausible: the measurement does not become plausible again after missed periods");
  }

  void fall_silent() {
    const Measured m = after_pause(p_.silent_periods);
    require(m.applied.last_state() == gates_off || !m.plausible,
            "silence: the gates are on without a new pattern");
    (void)start("plausible: the measurement does not become plausible again after a silence");
  }

  /// The measurement that many periods after V1 has been written.
  Measured after_pause(int periods) {
    (void)period({switch_states[1], p_.period_ns});
    t_ns_ += (periods - 1) * std::int64_t{p_.period_ns};
    written_.clear();
    return read();
  }

  /// One control period.
  Measured period(const GatePattern& pattern) {
    const Measured m = read();
    io_.write(pattern);
    written_.push_back(pattern);
    return m;
  }

  Measured read() {
    t_ns_ += p_.period_ns;
    if (p_.wait) p_.wait(t_ns_);
    const Measured m = io_.read(t_ns_);
    if (is_regular_) require(m.plausible, "plausible: the measurement is not plausible");
    if (m.plausible) {
      check_values(m);
      if (has_read_) check_duration(m.applied, t_ns_ - last_ns_);
      check_applied(m.applied);
    }
    has_read_ = m.plausible;
    last_ns_ = t_ns_;
    return m;
  }

  void check_values(const Measured& m) {
    bool finite = std::isfinite(m.u_dc) && std::isfinite(m.omega_m);
    for (const T i : currents(m)) finite = finite && std::isfinite(i);
    finite = finite && std::isfinite(m.winding_temperature.value_or(T(0)));
    require(finite, "finite: a value of a plausible measurement is not finite");
    require(std::abs(m.theta_m.value_or(T(0))) <= std::numbers::pi_v<T>,
            "finite: the angle of the rotor is not within [-pi, pi]");
  }

  void check_duration(const GatePattern& applied, std::int64_t elapsed_ns) {
    const auto negative = [](const GateSegment& s) { return s.duration_ns < 0; };
    require(std::ranges::none_of(applied.segments(), negative),
            "duration: a segment of the applied pattern has a negative duration");
    const std::int64_t error_ns = applied.duration_ns() - elapsed_ns;
    require(std::abs(error_ns) <= std::int64_t(GatePattern::capacity) * p_.resolution_ns,
            "duration: the applied pattern has " + std::to_string(applied.duration_ns()) + " ns where " +
                std::to_string(elapsed_ns) + " ns have passed since the last read");
  }

  void check_applied(const GatePattern& applied) {
    const std::size_t ago = std::size_t(p_.actuation_delay_periods) + 1;
    if (!is_regular_ || written_.size() < ago) return;
    const GatePattern& written = written_[written_.size() - ago];
    const GatePattern expected = written.segments().empty() ? off() : written;
    if (expected == off()) {
      const auto is_off = [](const GateSegment& s) { return s.state == gates_off; };
      require(std::ranges::all_of(applied.segments(), is_off), "off: a leg is driven after gates off");
      return;
    }
    const auto same = [this](const GateSegment& a, const GateSegment& b) {
      return a.state == b.state && std::abs(std::int64_t{a.duration_ns} - b.duration_ns) <= p_.resolution_ns;
    };
    require(std::ranges::equal(applied.segments(), expected.segments(), same),
            "applied: the applied pattern is not the one that was written for the period");
  }

  /// Of the current over a pattern of V1, V3 or V5.
  void check_rise(const GatePattern& pattern, const std::array<T, 3>& before, const std::array<T, 3>& after) {
    const std::array<SwitchState, 3> along{switch_states[1], switch_states[3], switch_states[5]};
    const auto* const found = std::ranges::find(along, pattern.last_state());
    if (!p_.has_machine || pattern.segments().size() != 1 || found == along.end()) return;
    const auto leg = std::size_t(found - along.begin());
    std::array<T, 3> rise{};
    for (std::size_t x = 0; x < 3; ++x) rise[x] = after[x] - before[x];
    const bool others_fall = rise[(leg + 1) % 3] < T(0) && rise[(leg + 2) % 3] < T(0);
    const bool is_closed = std::abs(rise[0] + rise[1] + rise[2]) <= T(0.1) * rise[leg];
    require(rise[leg] > T(0) && others_fall && is_closed,
            "currents: V" + std::to_string(2 * leg + 1) + " changes the currents of a, b and c by " +
                std::to_string(rise[0]) + ", " + std::to_string(rise[1]) + " and " + std::to_string(rise[2]) +
                " A");
  }

  [[nodiscard]] static std::array<T, 3> currents(const Measured& m) {
    return {m.i_abc.a, m.i_abc.b, m.i_abc.c};
  }

  /// Keeps the first violation of each rule.
  void require(bool holds, const std::string& sentence) {
    if (holds || result_.has(sentence.substr(0, sentence.find(':') + 1))) return;
    result_.violations.push_back(sentence + ", first " +
                                 std::to_string((t_ns_ - p_.begin_ns) / p_.period_ns) +
                                 " periods after the beginning");
  }

  DriveIo<T>& io_;
  DriveIoConformanceParameters p_;
  ConformanceResult result_{};
  std::vector<GatePattern> written_{};  ///< in periods without a gap
  std::int64_t t_ns_;                   ///< of the last read [ns]
  std::int64_t last_ns_{};              ///< of the read before [ns]
  bool has_read_{false};                ///< that had a plausible measurement
  bool is_regular_{false};              ///< a pattern is written in every period
};

/// Checks a power stage; turns its gates on for single periods.
template <class T>
[[nodiscard]] ConformanceResult check_drive_io(DriveIo<T>& io, DriveIoConformanceParameters parameters = {}) {
  return DriveIoCheck<T>{io, std::move(parameters)}.run();
}

}  // namespace sextant
