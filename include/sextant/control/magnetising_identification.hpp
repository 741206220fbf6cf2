#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Identifies R_s, R_r and L_m while the machine is magnetised by a current in the direction of its rotor
/// flux, at any speed. Then there is neither slip nor torque, and in the frame of the rotor flux, with
/// φ = k_r ψ_r, the voltage behind the leakage is
///   u − σL_s di/dt = R_s i + dφ/dt + j ω_r φ,   dφ/dt = k_r² R_r i − (R_r/L_r) φ,   ω_r = p ω_m
/// Its part across the flux gives φ without any resistance; the part along the flux, integrated, then gives
/// R_s, and the course of φ gives R_r and L_r by least squares. Near standstill φ comes from the current
/// model instead, and R_r and L_m stay as they are. All signals pass the same low-pass filter. Source of the
/// equations: P. Vas, Sensorless Vector and Direct Torque Control, Oxford 1998, section 2.1.
template <class T = double>
class MagnetisingIdentification {
 public:
  using Machine = InductionMachineParameters<T>;

  /// Starts from the parameters as they are configured.
  explicit MagnetisingIdentification(const Machine& machine) noexcept
      : nominal_{machine},
        machine_{machine},
        filter_time_{T(0.04) * machine.tau_r()},
        shortest_{T(0.2) * machine.tau_r()},
        resistances_{machine.r_s + machine.k_r() * machine.k_r() * machine.r_r},
        low_{machine.r_s / machine.l_s()},
        high_{T(60) * machine.r_s / machine.l_s()} {}

  /// Magnetising begins at rotor flux phi = k_r |ψ_r| [Wb] and speed omega_r [rad/s].
  void begin(T phi, T omega_r) noexcept {
    flux_ = model_flux_ = phi;
    omega_r_ = omega_r;
    voltage_ = {T(0), omega_r * phi};
    current_ = time_ = lag_ = T(0);
    sums_ = {};
  }

  /// One period of dt [s] in the frame of the rotor flux: `voltage` behind the leakage [V], stator current
  /// [A], `model_flux` k_r |ψ_r| of the current model [Wb].
  void step(SpaceVector<T> voltage, SpaceVector<T> i_s, T model_flux, T omega_r, T dt) noexcept {
    const T k = dt / filter_time_;
    // The ripple across the flux, with its voltage at both resistances.
    const SpaceVector<T> seen_voltage{voltage.alpha, voltage.beta - resistances_ * i_s.beta};
    const T current = i_s.alpha;
    voltage_ += k * (seen_voltage - voltage_);
    current_ += k * (current - current_);
    model_flux_ += k * (model_flux - model_flux_);
    lag_ = model_flux - model_flux_;
    omega_r_ += k * (omega_r - omega_r_);
    seen_ = share(omega_r_, low_);
    const T measured = seen_ > T(0) ? voltage_.beta / omega_r_ : T(0);
    flux_ = seen_ * measured + (T(1) - seen_) * model_flux_;
    time_ += dt;
    if (!(time_ > T(4) * filter_time_)) return;  // the filter has not forgotten how it began
    sums_.add(voltage_.alpha, current_, flux_, seen_, dt);
    if (is_identified()) identify_stator(omega_r_);
  }

  /// φ: filtered, and the current model's for what is faster than the filter; at least a third of that of the
  /// current model, because while there is little flux noise may exceed it. [Wb]
  [[nodiscard]] T flux() const noexcept { return std::max(flux_ + lag_, (model_flux_ + lag_) / T(3)); }
  /// Time since magnetising began. [s]
  [[nodiscard]] T time() const noexcept { return time_; }
  /// Time after which the parameters are identified. [s]
  [[nodiscard]] T settling_time() const noexcept { return T(4) * filter_time_ + shortest_; }

  /// The parameters with what is identified so far. Call at the end of magnetising.
  [[nodiscard]] const Machine& finish() noexcept {
    T slope_of_current{};
    T slope_of_flux{};
    if (!is_identified() || !sums_.solve(slope_of_current, slope_of_flux)) return machine_;
    const T r_r = slope_of_current / (nominal_.k_r() * nominal_.k_r());
    const T l_m = r_r / slope_of_flux - nominal_.l_lr;
    if (!is_near(r_r, nominal_.r_r) || !is_near(l_m, nominal_.l_m)) return machine_;
    machine_.r_r = nominal_.r_r + seen_ * (r_r - nominal_.r_r);
    machine_.l_m = nominal_.l_m + seen_ * (l_m - nominal_.l_m);
    return machine_;
  }

  /// Stator resistance. [Ω]
  [[nodiscard]] T r_s() const noexcept { return machine_.r_s; }

 private:
  /// Integrals since the filter has settled, and the sums of Δφ = a ∫i dt − b ∫φ dt.
  struct Sums {
    T time{}, volt_seconds{}, charge{}, area{}, first{}, change{}, first_seen{};
    T qq{}, qa{}, aa{}, qf{}, af{};
    bool any{false};

    void add(T voltage, T current, T flux, T seen, T dt) noexcept {
      if (!any) first = flux;
      if (!any) first_seen = seen;
      any = true;
      time += dt;
      volt_seconds += dt * voltage;
      charge += dt * current;
      area += dt * flux;
      change = flux - first;
      qq += charge * charge;
      qa += charge * area;
      aa += area * area;
      qf += charge * change;
      af += area * change;
    }
    /// False where the course does not tell a from b.
    [[nodiscard]] bool solve(T& a, T& b) const noexcept {
      const T determinant = qq * aa - qa * qa;
      if (!(determinant > T(0))) return false;
      a = (qf * aa - af * qa) / determinant;
      b = (qf * qa - af * qq) / determinant;
      return a > T(0) && b > T(0);
    }
  };

  /// x⁴/(x⁴ + corner⁴).
  [[nodiscard]] static T share(T x, T corner) noexcept {
    const T ratio = x * x / (corner * corner);
    return ratio * ratio / (T(1) + ratio * ratio);
  }

  [[nodiscard]] static bool is_near(T value, T nominal) noexcept {
    return value > T(0.3) * nominal && value < T(3) * nominal;
  }

  /// Long enough, and with φ from the same source throughout: a shaft that leaves standstill meanwhile
  /// changes it.
  [[nodiscard]] bool is_identified() const noexcept {
    return sums_.time > shortest_ && std::abs(seen_ - sums_.first_seen) < T(0.1);
  }

  /// At high speed a small angle between current and flux counts as resistance; there it has no weight.
  void identify_stator(T omega_r) noexcept {
    if (!(sums_.charge > T(0))) return;
    const T r_s = (sums_.volt_seconds - sums_.change) / sums_.charge;
    const T ratio = omega_r / high_;
    const T weight = T(1) / (T(1) + ratio * ratio);
    machine_.r_s = std::clamp(nominal_.r_s + weight * (r_s - nominal_.r_s), T(0.4) * nominal_.r_s,
                              T(2.2) * nominal_.r_s);
  }

  Machine nominal_;
  Machine machine_;
  T filter_time_;             ///< [s]
  T shortest_;                ///< time over which the parameters are identified [s]
  T resistances_;             ///< R_s + k_r² R_r [Ω]
  T low_;                     ///< ω_r above which φ is measured [rad/s]
  T high_;                    ///< ω_r above which R_s is not identified [rad/s]
  SpaceVector<T> voltage_{};  ///< filtered [V]
  T current_{};
  T model_flux_{};
  T flux_{};
  T lag_{};  ///< of the current model behind its filter [Wb]
  T time_{};
  T omega_r_{};  ///< filtered [rad/s]
  T seen_{};     ///< share of the measured flux in φ [-]
  Sums sums_{};
};

}  // namespace sextant
