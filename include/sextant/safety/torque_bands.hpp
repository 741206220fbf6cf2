#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sextant/safety/candidate_machine.hpp"
#include "sextant/safety/torque_monitor_limits.hpp"
#include "sextant/safety/torque_window.hpp"

namespace sextant {

/// An estimated torque, and the band in which the true one lies.
template <class T = double>
struct TorqueBand {
  T torque{};   ///< [N·m]
  T lowest{};   ///< [N·m]
  T highest{};  ///< [N·m]

  [[nodiscard]] constexpr T width() const noexcept { return highest - lowest; }

  /// So that it contains this torque.
  constexpr void include(T x) noexcept {
    lowest = std::min(lowest, x);
    highest = std::max(highest, x);
  }
  constexpr void spread(T x) noexcept {
    lowest -= x;
    highest += x;
  }
};

/// The torque of one averaging time by two methods, each with its band.
///   By current: the torques of the machine as given and of the four corners of the errors of R_r and L_m.
///   By power: the same five, each with R_s at both ends of its error, which adds
///   3/2 p (ΔR_s |i_s|² + δu |i_s|)/|ω_e|, δu the voltage error along the current, two standard deviations of
///   it; no band where the candidates do not agree on the sign of ω_e.
/// Both are wider by sensor_share |τ_e| and by 3/2 p |ψ_r| δi for an offset δi of the current; by current
/// 3/2 p L_m |i_s| δi is added, the flux that the offset makes at standstill. The narrower band counts: by
/// current near zero stator frequency, by power from there.
template <class T = double>
class TorqueBands {
 public:
  explicit TorqueBands(const TorqueMonitorLimits<T>& p) noexcept
      : offset_gain_{T(1.5) * T(p.machine.pole_pairs) * p.current_offset},
        l_m_{p.machine.l_m},
        sensor_share_{p.sensor_share},
        r_s_errors_{-p.machine.r_s * p.r_s_share, p.machine.r_s * (highest_factor(p.r_s_share) - T(1))},
        voltage_error_{T(2) * p.inverter.voltage_error} {
    const T least = T(1e-6) * p.flux_reference * p.flux_reference;
    const auto candidate = [&p, least](T r_r, T l_m) {
      return CandidateMachine<T>{p.machine, r_r, l_m, least};
    };
    const T r_low = lowest_factor(p.r_r_share);
    const T r_high = highest_factor(p.r_r_share);
    const T l_low = lowest_factor(p.l_m_share);
    const T l_high = highest_factor(p.l_m_share);
    candidates_ = {candidate(T(1), T(1)), candidate(r_low, l_low), candidate(r_low, l_high),
                   candidate(r_high, l_low), candidate(r_high, l_high)};
  }

  /// R_r and inductances of the monitor from here on.
  void set_machine(const InductionMachineParameters<T>& machine) noexcept {
    l_m_ = machine.l_m;
    for (CandidateMachine<T>& candidate : candidates_) candidate.set_machine(machine);
  }

  /// dt [s] without current, before the next averaging time.
  void decay(T dt) noexcept {
    for (CandidateMachine<T>& candidate : candidates_) candidate.decay(dt);
  }

  /// Takes the errors of the sensors from another one for the same machine and shares of its parameters.
  constexpr void take_parameters(const TorqueBands& from) noexcept {
    offset_gain_ = from.offset_gain_;
    sensor_share_ = from.sensor_share_;
  }

  void step(const TorqueMeans<T>& m) noexcept {
    T slowest = std::numeric_limits<T>::infinity();
    T fastest = -slowest;
    bool first = true;
    const T current = std::sqrt(m.current_squared);
    // What δu of the voltage is as a resistance.
    const T ohms = current > T(0) ? voltage_error_ / current : T(0);
    for (CandidateMachine<T>& candidate : candidates_) {
      candidate.step(m);
      const CandidateTorque<T> t = candidate.torque(m);
      if (first) {
        by_current_ = {t.by_current, t.by_current, t.by_current};
        by_power_ = {t.by_power, t.by_power, t.by_power};
        first = false;
      }
      by_current_.include(t.by_current);
      by_power_.include(t.by_power + t.per_stator_ohm * (r_s_errors_[0] - ohms));
      by_power_.include(t.by_power + t.per_stator_ohm * (r_s_errors_[1] + ohms));
      slowest = std::min(slowest, t.omega_e);
      fastest = std::max(fastest, t.omega_e);
    }
    turns_ = slowest > T(0) || fastest < T(0);
    const T flux = std::sqrt(m.flux_squared);
    const T flux_of_current = l_m_ * current;
    by_current_.spread(sensor_share_ * std::abs(by_current_.torque) +
                       offset_gain_ * (flux + flux_of_current));
    by_power_.spread(sensor_share_ * std::abs(by_power_.torque) + offset_gain_ * flux);
  }

  [[nodiscard]] constexpr const TorqueBand<T>& by_current() const noexcept { return by_current_; }
  /// Meaningful where `has_power`.
  [[nodiscard]] constexpr const TorqueBand<T>& by_power() const noexcept { return by_power_; }
  /// The flux turns, the same way in every candidate.
  [[nodiscard]] constexpr bool has_power() const noexcept { return turns_; }

  /// By how much the rotor flux of the true machine may differ from that of `MonitoredFlux`, as a share of
  /// it: the largest |g − 1| of the candidates. In steady state it is below 1. In transients it has no bound:
  /// the candidates' fluxes follow the current with time constants of 0.4 to 2.1 times the monitor's, so that
  /// its flux may decay, or pass through zero, while that of the machine is still there. [-]
  [[nodiscard]] T flux_error() const noexcept {
    T largest{};
    for (const CandidateMachine<T>& candidate : candidates_) {
      const SpaceVector<T> difference = candidate.flux_ratio() - SpaceVector<T>{T(1), T(0)};
      largest = std::max(largest, dot(difference, difference));
    }
    return std::sqrt(largest);
  }

  [[nodiscard]] constexpr const TorqueBand<T>& narrower() const noexcept {
    return turns_ && by_power_.width() < by_current_.width() ? by_power_ : by_current_;
  }

 private:
  /// True value by given value, where the given one is 1 + share times the true one.
  [[nodiscard]] static constexpr T lowest_factor(T share) noexcept { return T(1) / (T(1) + share); }
  [[nodiscard]] static constexpr T highest_factor(T share) noexcept { return T(1) / (T(1) - share); }

  T offset_gain_;  ///< 3/2 p δi [A]
  T l_m_;
  T sensor_share_;
  std::array<T, 2> r_s_errors_;  ///< true minus given R_s [Ω]
  T voltage_error_;              ///< δu [V]
  std::array<CandidateMachine<T>, 5> candidates_{};
  TorqueBand<T> by_current_{};
  TorqueBand<T> by_power_{};
  bool turns_{false};
};

}  // namespace sextant
