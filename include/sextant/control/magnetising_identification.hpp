#pragma once

#include <algorithm>
#include <cmath>

#include "sextant/control/flux_course.hpp"
#include "sextant/control/parameter_prior.hpp"
#include "sextant/control/standstill_course.hpp"
#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Identifies R_s, R_r and L_m while the machine is magnetised by a current in the direction of its rotor
/// flux, at any speed. Then there is neither slip nor torque, and in the frame of the rotor flux, with
/// φ = k_r ψ_r, the voltage behind the leakage is
///   u − σL_s di/dt = R_s i + dφ/dt + j ω_r φ,   dφ/dt = k_r² R_r i − (R_r/L_r) φ,   ω_r = p ω_m
/// Its part across the flux gives φ without any resistance; the part along the flux, integrated, then gives
/// R_s, and the course of φ gives R_r and L_r (`FluxCourse`). Near standstill the curve of the voltage along
/// the flux gives all three (`StandstillCourse`), and φ comes from the current model until then. All signals
/// pass the same low-pass filter, of order two because the noise of the current counts by its slope. Source
/// of the equations: P. Vas, Sensorless Vector and Direct Torque Control, Oxford 1998.
template <class T = double>
class MagnetisingIdentification {
 public:
  using Machine = InductionMachineParameters<T>;

  /// Starts from the parameters as they are configured.
  explicit MagnetisingIdentification(const Machine& machine) noexcept
      : nominal_{machine},
        filter_time_{T(0.04) * machine.tau_r()},
        shortest_{T(0.2) * machine.tau_r()},
        resistances_{machine.r_s + machine.k_r() * machine.k_r() * machine.r_r},
        low_{machine.r_s / machine.l_s()},
        high_{T(240) * machine.r_s / machine.l_s()},
        course_{machine, T(2) * filter_time_},
        standstill_{machine} {}

  /// Magnetising begins at rotor flux phi = k_r |ψ_r| [Wb] and speed omega_r [rad/s].
  void begin(T phi, T omega_r) noexcept {
    flux_ = phi;
    model_flux_.set(phi);
    omega_r_.set(omega_r);
    along_.set(T(0));
    across_.set(omega_r * phi);
    current_.set(T(0));
    time_ = lag_ = T(0);
    first_seen_ = T(-1);
    course_.reset();
    standstill_.begin(phi);
  }

  /// One period of dt [s] in the frame of the rotor flux: `voltage` behind the leakage [V], stator current
  /// [A], `model_flux` k_r |ψ_r| of the current model [Wb].
  void step(SpaceVector<T> voltage, SpaceVector<T> i_s, T model_flux, T omega_r, T dt) noexcept {
    standstill_.add(voltage.alpha, i_s.alpha, dt);
    const T k = dt / (T(0.5) * filter_time_ + dt);
    along_.step(voltage.alpha, k);
    // The ripple across the flux, with its voltage at both resistances.
    across_.step(voltage.beta - resistances_ * i_s.beta, k);
    current_.step(i_s.alpha, k);
    model_flux_.step(model_flux, k);
    lag_ = model_flux - model_flux_.value();
    omega_r_.step(omega_r, k);
    seen_ = share(omega_r_.value(), low_);
    const T measured = seen_ > T(0) ? across_.value() / omega_r_.value() : T(0);
    flux_ = seen_ * measured + (T(1) - seen_) * model_flux_.value();
    time_ += dt;
    if (!(time_ > T(4) * filter_time_)) return;  // the filter has not forgotten how it began
    if (first_seen_ < T(0)) first_seen_ = seen_;
    course_.add(along_.value(), current_.value(), flux_, dt);
  }

  /// φ: filtered, and the current model's for what is faster than the filter; at least a third of that of the
  /// current model, because while there is little flux noise may exceed it. [Wb]
  [[nodiscard]] T flux() const noexcept {
    return std::max(flux_ + lag_, (model_flux_.value() + lag_) / T(3));
  }
  /// Time after which the parameters are identified. [s]
  [[nodiscard]] T settling_time() const noexcept { return T(4) * filter_time_ + shortest_; }

  /// The parameters in use with what is identified so far in their place; the flux is then that of the
  /// course. Call at the end of magnetising.
  [[nodiscard]] Machine finish(Machine machine) noexcept {
    if (!is_identified()) return machine;
    const Result found = mixed(course_.solve(), standstill_.result());
    flux_ = found.flux;
    machine.r_s += stator_weight() * (Prior::bounded(found.r_s, nominal_.r_s) - machine.r_s);
    if (!Prior::allows(found.r_r, nominal_.r_r) || !Prior::allows(found.l_m, nominal_.l_m)) return machine;
    machine.r_r = found.r_r;
    machine.l_m = found.l_m;
    return machine;
  }

 private:
  using Prior = ParameterPrior<T>;
  using Result = typename FluxCourse<T>::Result;

  /// By the share of the measured flux.
  [[nodiscard]] Result mixed(const Result& turning, const Result& still) const noexcept {
    const auto mix = [s = seen_](T x, T y) { return y + s * (x - y); };
    return {.r_s = mix(turning.r_s, still.r_s),
            .r_r = mix(turning.r_r, still.r_r),
            .l_m = mix(turning.l_m, still.l_m),
            .flux = mix(turning.flux, still.flux - lag_)};
  }

  /// x⁴/(x⁴ + corner⁴).
  [[nodiscard]] static T share(T x, T corner) noexcept {
    const T ratio = x * x / (corner * corner);
    return ratio * ratio / (T(1) + ratio * ratio);
  }

  /// Long enough, and with φ from the same source throughout: a shaft that leaves standstill meanwhile
  /// changes it.
  [[nodiscard]] bool is_identified() const noexcept {
    return course_.time() > shortest_ && std::abs(seen_ - first_seen_) < T(0.1);
  }

  /// Of the identified R_s: at high speed a small angle between current and flux counts as resistance. [-]
  [[nodiscard]] T stator_weight() const noexcept {
    const T ratio = omega_r_.value() / high_;
    return T(1) / (T(1) + ratio * ratio);
  }

  /// Two first-order low-pass filters, each of half the filter time.
  class LowPass {
   public:
    void set(T x) noexcept { first_ = second_ = x; }
    void step(T x, T k) noexcept {
      first_ += k * (x - first_);
      second_ += k * (first_ - second_);
    }
    [[nodiscard]] T value() const noexcept { return second_; }

   private:
    T first_{};
    T second_{};
  };

  Machine nominal_;
  T filter_time_;         ///< [s]
  T shortest_;            ///< time over which the parameters are identified [s]
  T resistances_;         ///< R_s + k_r² R_r [Ω]
  T low_;                 ///< ω_r above which φ is measured [rad/s]
  T high_;                ///< ω_r above which R_s is not identified [rad/s]
  LowPass along_{};       ///< voltage along the flux [V]
  LowPass across_{};      ///< and across it [V]
  LowPass current_{};     ///< [A]
  LowPass model_flux_{};  ///< [Wb]
  LowPass omega_r_{};     ///< [rad/s]
  T flux_{};              ///< [Wb]
  T lag_{};               ///< of the current model behind its filter [Wb]
  T time_{};              ///< [s]
  T seen_{};              ///< share of the measured flux in φ [-]
  T first_seen_{T(-1)};   ///< the same where the course begins; below zero before [-]
  FluxCourse<T> course_;
  StandstillCourse<T> standstill_;
};

}  // namespace sextant
