#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "sextant/core/inverter_model.hpp"
#include "sextant/core/iron_torque.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/saturation_curve.hpp"
#include "sextant/safety/monitored_flux.hpp"
#include "sextant/safety/torque_bands.hpp"
#include "sextant/safety/torque_monitor_limits.hpp"
#include "sextant/safety/torque_reach.hpp"
#include "sextant/safety/torque_window.hpp"

namespace sextant {

/// Independent torque monitor: compares the torque with the command of the command supervision, with
/// code and state of its own above `core`, and parameters of its own. Over each averaging time the
/// torque is estimated by current and by power (`TorqueBands`). The averaging time is violated where the
/// whole band lies
///   further than max(limit, limit_share |command|) from the mean command, or
///   beyond `wrong_sign` against the command's sign,
/// and beyond what there has been time to reach (`TorqueReach`) by as much.
/// Each violated averaging time counts up, each other one down. The deviation is a fault when the count comes
/// to `time` less one averaging time, so that a deviation lasts for at most `time`. Without torque production
/// the count is zero; while gates were off within a period the averaging time begins anew.
///
/// Where the saturation of the main flux is given, the machine is that at the stator flux of its own
/// currents, k_r ψ_r + σL_s i_s, at the end of the averaging time before, with gates off of the period before
/// (`SaturationCurve::machine_at`).
///
/// Not violated, although torque lacks: |ψ_r| is below half of the flux reference and grows (L_m i_d exceeds
/// ψ_r by a tenth), as at the start of a machine without flux.
///
/// Not seen:
///   a deviation within limit and band: near zero stator frequency the band by current is up to twice the
///   torque (errors of R_r and L_m), elsewhere that of R_s |i_s|²/ω_e;
///   oscillation whose sign changes more often than every `time`, and torque while the gates are off;
///   errors of the measurements themselves: currents that read low by a common factor, a wrong speed or link
///   voltage; a command that is wrong before the supervision;
///   friction: the torque is that of the air gap, less `iron_torque` where the iron loss is given; iron loss
///   and saturation that are not.
template <class T = double>
class TorqueMonitor {
 public:
  using Parameters = TorqueMonitorLimits<T>;

  explicit TorqueMonitor(const Parameters& parameters) noexcept
      : parameters_{parameters},
        window_s_{T(parameters.window_ns) * T(1e-9)},
        trip_s_{T(parameters.time_ns - parameters.window_ns) * T(1e-9)},
        present_{parameters.machine},
        saturation_{parameters.saturation, parameters.machine.l_s()},
        inverter_{parameters.inverter, parameters.machine.sigma_l_s()},
        flux_{parameters.machine},
        window_{parameters.machine},
        bands_{parameters},
        reach_{parameters.machine, parameters.flux_reference} {}

  /// A usable measurement, dt [s] after the one before; `commanded`: torque command of that time [N·m], empty
  /// where the drive made no torque. True while the deviation is a fault.
  [[nodiscard]] bool step(const Measurement<T>& m, T dt, std::optional<T> commanded) noexcept {
    const bool is_repeated = !m.applied.segments().empty() && m.applied.duration_ns() == 0;
    if (is_repeated) return is_fault();  // a period without a new measurement
    const ThreePhase<T> beyond = inverter_.step(m.applied, m.i_abc, m.u_dc);
    const SpaceVector<T> i_before = i_s_;
    const T omega_m = T(0.5) * (omega_m_ + m.omega_m);
    i_s_ = clarke(m.i_abc);
    omega_m_ = m.omega_m;
    const bool driven = m.applied.is_driven();
    const T command = commanded.value_or(T(0));
    // With gates off the current decays within a fraction of a millisecond.
    flux_.step(driven ? T(0.5) * (i_before + i_s_) : i_s_, omega_m, dt);
    note_decay(driven, dt);
    if (!commanded) reset_comparison();
    if (!driven) {
      follow_saturation();
      window_.clear();
      return false;
    }
    if (commanded) {
      reach_.step({flux_.psi_r(), i_s_, m.omega_m, m.u_dc}, command, tolerance(command), dt);
    }
    window_.add(m.applied, dt, m.u_dc, i_before, i_s_, flux_.psi_r(), m.omega_m, command, reach_.torque(),
                beyond);
    if (window_.duration() + T(0.5) * dt >= window_s_) {
      const TorqueMeans<T> means = window_.means();
      follow(means);
      if (commanded) compare(means);
      window_.clear();
    }
    return is_fault();
  }

  /// dt [s] without a usable measurement: the gates are off.
  void coast(T dt) noexcept {
    i_s_ = {};
    flux_.step(i_s_, omega_m_, dt);
    follow_saturation();
    decay_s_ += dt;
    window_.clear();
    reset_comparison();
  }

  /// Takes the limits of another one for the same machine and shares of its parameters; fluxes, means and
  /// the count of violations stay.
  void take_parameters(const TorqueMonitor& from) noexcept {
    parameters_ = from.parameters_;
    window_s_ = from.window_s_;
    trip_s_ = from.trip_s_;
    bands_.take_parameters(from.bands_);
  }

  /// Estimated torque of the last averaging time; zero while the drive makes no torque. [N·m]
  [[nodiscard]] constexpr T torque() const noexcept { return band_.torque; }
  /// Rotor flux at the last measurement, stationary frame. [Wb]
  [[nodiscard]] constexpr SpaceVector<T> psi_r() const noexcept { return flux_.psi_r(); }
  /// By how much it may be wrong, by the candidates at the last averaging time. [Wb]
  [[nodiscard]] constexpr T psi_r_error() const noexcept { return psi_r_error_; }
  /// The same with its band.
  [[nodiscard]] constexpr const TorqueBand<T>& band() const noexcept { return band_; }
  /// Both methods.
  [[nodiscard]] constexpr const TorqueBands<T>& bands() const noexcept { return bands_; }
  /// The torque that there has been time to reach.
  [[nodiscard]] constexpr const TorqueReach<T>& reach() const noexcept { return reach_; }
  /// The voltage has held the torque off its command for the whole of the last averaging time.
  [[nodiscard]] constexpr bool lags() const noexcept { return lags_; }

 private:
  [[nodiscard]] bool is_fault() const noexcept {
    return parameters_.enabled && violated_s_ + T(0.5) * window_s_ >= trip_s_;
  }

  /// Largest deviation from a command [N·m] that does not count. [N·m]
  [[nodiscard]] constexpr T tolerance(T commanded) const noexcept {
    return std::max(parameters_.limit, parameters_.limit_share * std::abs(commanded));
  }

  constexpr void reset_comparison() noexcept {
    reach_.reset();
    lags_ = false;
    violated_s_ = T(0);
    band_ = {};
  }

  /// The candidates' fluxes have decayed without current until the gates are on again.
  void note_decay(bool driven, T dt) noexcept {
    if (!driven) {
      decay_s_ += dt;
    } else if (decay_s_ > T(0)) {
      bands_.decay(decay_s_);
      decay_s_ = T(0);
      psi_r_error_ = bands_.flux_error() * magnitude(flux_.psi_r());
    }
  }

  /// The candidates' fluxes, also while the machine is magnetised.
  void follow(const TorqueMeans<T>& m) noexcept {
    bands_.step(m);
    follow_saturation();
    psi_r_error_ = bands_.flux_error() * magnitude(flux_.psi_r());
  }

  void follow_saturation() noexcept {
    if (!saturation_.acts()) return;
    const SpaceVector<T> psi_s = present_.k_r() * flux_.psi_r() + present_.sigma_l_s() * i_s_;
    present_ = saturation_.machine_at(parameters_.machine, psi_s);
    flux_.set_machine(present_);
    bands_.set_machine(present_);
    reach_.set_machine(present_);
  }

  void compare(const TorqueMeans<T>& m) noexcept {
    band_ = bands_.narrower();
    if (parameters_.iron_loss_resistance < no_iron_loss<T>) subtract_iron_loss(m);
    reach_.follow(band_.torque, tolerance(m.commanded), std::min(T(1), m.duration / trip_s_));
    lags_ = reach_.lag() >= m.duration && std::abs(m.commanded - reach_.torque()) > tolerance(m.commanded);
    violated_s_ = std::max(T(0), violated_s_ + (is_violated(m) ? m.duration : -m.duration));
  }

  /// Of the flux without torque, L_s/L_m ψ_r, that turns with the shaft: the slip counts little where the
  /// loss does.
  void subtract_iron_loss(const TorqueMeans<T>& m) noexcept {
    const T pole_pairs = T(present_.pole_pairs);
    const T ratio = present_.l_s() / present_.l_m;
    const T lost = iron_torque(T(1.5) * pole_pairs, T(1) / parameters_.iron_loss_resistance,
                               pole_pairs * m.omega_m, ratio * ratio * m.flux_squared);
    band_ = {band_.torque - lost, band_.lowest - lost, band_.highest - lost};
  }

  [[nodiscard]] bool is_violated(const TorqueMeans<T>& m) const noexcept {
    const T commanded = m.commanded;
    const T lowest = std::min(commanded, m.reached);
    const T highest = std::max(commanded, m.reached);
    if (commanded > T(0) && band_.highest < std::min(T(0), lowest) - parameters_.wrong_sign) return true;
    if (commanded < T(0) && band_.lowest > std::max(T(0), highest) + parameters_.wrong_sign) return true;
    const T limit = tolerance(commanded);
    if (band_.lowest <= highest + limit && band_.highest >= lowest - limit) return false;
    const bool lacks = std::abs(band_.torque) < std::abs(commanded);
    return !(lacks && flux_builds_up(m));
  }

  [[nodiscard]] bool flux_builds_up(const TorqueMeans<T>& m) const noexcept {
    const T half = T(0.5) * parameters_.flux_reference;
    return m.flux_squared < half * half && present_.l_m * m.along > T(1.1) * m.flux_squared;
  }

  Parameters parameters_;
  T window_s_;
  T trip_s_;
  InductionMachineParameters<T> present_;  ///< at the present flux
  SaturationCurve<T> saturation_;
  InverterModel<T> inverter_;
  MonitoredFlux<T> flux_;
  TorqueWindow<T> window_;
  TorqueBands<T> bands_;
  TorqueReach<T> reach_;
  TorqueBand<T> band_{};
  SpaceVector<T> i_s_{};  ///< at the last measurement [A]
  T omega_m_{};           ///< at the last measurement [rad/s]
  T decay_s_{};           ///< time with gates off that the candidates' fluxes have not followed yet [s]
  T psi_r_error_{};       ///< of `MonitoredFlux` [Wb]
  bool lags_{false};
  T violated_s_{};  ///< count of violated averaging times [s]
};

}  // namespace sextant
