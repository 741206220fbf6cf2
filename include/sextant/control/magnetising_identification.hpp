#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "sextant/control/flux_course.hpp"
#include "sextant/control/flux_crossover.hpp"
#include "sextant/control/parameter_covariance.hpp"
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
/// pass the same low-pass filter, of order two because the noise of the current counts by its slope. φ is the
/// current model's and its error by least squares (`FluxError`), which has no pole where the speed passes
/// through zero. Nothing is identified over such a passage. By a current i along the flux
///   φ = φ_0 e^(−bt) + a ∫i e^(−b(t−s)) ds,   a = k_r² R_r,   b = R_r/L_r,
/// so that within the bounds of `ParameterPrior` the quotient of φ and that of the current model has the same
/// bounds; φ is kept within them.
///
/// The frame follows the measured speed. An encoder shows it late, by half of its window, so that the frame
/// of a shaft that gathers speed is off by an angle δ, the more the slower the flux follows: by some 10
/// degrees for 1 ms on a machine of 160 kW. What of the voltage along the flux no resistances within the
/// bounds explain is that of the flux across it, −ω_r φ sin δ, and turns the frame. Source of the equations:
/// P. Vas, Sensorless Vector and Direct Torque Control, Oxford 1998.
template <class T = double>
class MagnetisingIdentification {
 public:
  using Machine = InductionMachineParameters<T>;
  using Saturation = typename SaturationShape<T>::Knowledge;

  /// Starts from the parameters as they are configured. voltage_error: standard deviation of a constant error
  /// of the voltage along the current [V]; flux_reference: ψ_ref [Wb]; saturation: what is known of it.
  MagnetisingIdentification(const Machine& machine, T voltage_error, T flux_reference,
                            const Saturation& saturation = {}) noexcept
      : nominal_{machine},
        filter_time_{T(0.04) * machine.tau_r()},
        shortest_{T(0.2) * machine.tau_r()},
        resistances_{machine.r_s + machine.k_r() * machine.k_r() * machine.r_r},
        voltage_error_{voltage_error},
        low_{flux_crossover(machine, voltage_error, flux_reference)},
        high_{T(240) * machine.r_s / machine.l_s()},
        course_{machine, T(2) * filter_time_, voltage_error, flux_reference, saturation},
        standstill_{machine, voltage_error, flux_reference, saturation} {}

  /// Magnetising begins at rotor flux phi = k_r |ψ_r| [Wb] and speed omega_r [rad/s].
  void begin(T phi, T omega_r) noexcept {
    flux_ = phi;
    model_flux_.set(phi);
    omega_r_.set(omega_r);
    along_.set(T(0));
    error_.begin(omega_r);
    current_.set(T(0));
    time_ = lag_ = T(0);
    span_ = {};
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
    error_.step(voltage.beta - resistances_ * i_s.beta - omega_r * model_flux, omega_r, k);
    current_.step(i_s.alpha, k);
    model_flux_.step(model_flux, k);
    lag_ = model_flux - model_flux_.value();
    omega_r_.step(omega_r, k);
    seen_ = share(error_.square() / (low_ * low_));
    flux_ = model_flux_.value() + (seen_ > T(0) ? seen_ * error_.value() : T(0));
    time_ += dt;
    if (!is_filtered()) return;
    span_.add(seen_, omega_r_.value());
    course_.add(along_.value(), current_.value(), flux_, dt);
  }

  /// φ: filtered, and the current model's for what is faster than the filter, within what the current allows.
  /// [Wb]
  [[nodiscard]] T flux() const noexcept { return Prior::bounded(flux_ + lag_, model_flux_.value() + lag_); }
  /// Rotation that takes the frame to the rotor flux.
  [[nodiscard]] SpaceVector<T> direction() const noexcept {
    const T sine = lead();
    return {std::sqrt(T(1) - sine * sine), sine};
  }
  /// What of it is due within dt [s]: the frame follows in two filter times, which both stages of the filter
  /// leave a phase margin of 60 degrees.
  [[nodiscard]] SpaceVector<T> turn(T dt) const noexcept {
    const T angle = std::min(T(1), dt / (T(2) * filter_time_)) * lead();
    return {T(1) - T(0.5) * angle * angle, angle};
  }
  /// Time after which the parameters are identified. [s]
  [[nodiscard]] T settling_time() const noexcept { return T(4) * filter_time_ + shortest_; }

  /// The parameters in use with what is identified so far in their place; the flux is then that of the
  /// course. Of a course that finds a parameter at a bound or beyond nothing is taken over, nor is the flux
  /// by its voltages, which fit no machine within the bounds: that is the current model's then. Call at the
  /// end of magnetising.
  [[nodiscard]] Machine finish(Machine machine) noexcept {
    has_found_ = false;
    if (!is_identified()) return machine;
    const Result found = mixed(course_.solve(), standstill_.result());
    const T weight = stator_weight();
    const T r_s = machine.r_s + weight * (found.r_s - machine.r_s);
    const bool is_allowed = Prior::allows(r_s, nominal_.r_s) && Prior::allows(found.r_r, nominal_.r_r) &&
                            Prior::allows(found.l_m, nominal_.l_m);
    if (!is_allowed) {
      flux_ = model_flux_.value();
      return machine;
    }
    flux_ = found.flux;
    has_found_ = true;
    covariance_ = found.covariance;
    covariance_.ss = weight * covariance_.ss + (T(1) - weight) * ParameterCovariance<T>{}.ss;
    machine.r_s = r_s;
    machine.r_r = found.r_r;
    machine.l_m = found.l_m;
    covariance_.refer_to(machine.r_s / nominal_.r_s, machine.r_r / nominal_.r_r, machine.l_m / nominal_.l_m);
    return machine;
  }
  /// The last `finish` has taken parameters over.
  [[nodiscard]] constexpr bool has_found() const noexcept { return has_found_; }
  /// What it left unknown of them then.
  [[nodiscard]] constexpr const ParameterCovariance<T>& covariance() const noexcept { return covariance_; }

 private:
  using Prior = ParameterPrior<T>;
  using Result = typename FluxCourse<T>::Result;

  /// By the share of the measured flux.
  [[nodiscard]] Result mixed(const Result& turning, const Result& still) const noexcept {
    const auto mix = [s = seen_](T x, T y) { return y + s * (x - y); };
    return {.r_s = mix(turning.r_s, still.r_s),
            .r_r = mix(turning.r_r, still.r_r),
            .l_m = mix(turning.l_m, still.l_m),
            .flux = mix(turning.flux, still.flux - lag_),
            .covariance = sextant::mixed(turning.covariance, still.covariance, seen_)};
  }

  /// x²/(x² + 1).
  [[nodiscard]] static T share(T x) noexcept { return x * x / (T(1) + x * x); }

  /// The filter has forgotten how it began.
  [[nodiscard]] bool is_filtered() const noexcept { return time_ > T(4) * filter_time_; }

  /// sin δ, as far as φ is measured. [-]
  [[nodiscard]] T lead() const noexcept {
    const T emf = omega_r_.value() * model_flux_.value();
    if (!(std::abs(emf) > T(0)) || !is_filtered()) return T(0);
    return std::clamp(-seen_ * unexplained() / emf, T(-1), T(1));
  }

  /// Of the voltage along the flux, R_s i + dφ/dt: what no resistance within its bounds explains, nor the
  /// error of the voltage. φ rises by at most k_r² R_r i, and does not fall. [V]
  [[nodiscard]] T unexplained() const noexcept {
    const T i = current_.value();
    const auto [low, high] =
        std::minmax({Prior::lowest * nominal_.r_s * i, Prior::highest * resistances_ * i});
    return along_.value() - std::clamp(along_.value(), low - voltage_error_, high + voltage_error_);
  }

  /// Long enough, with φ from the same source throughout, and in one direction of rotation: a shaft that
  /// leaves standstill meanwhile, comes to it or passes through it changes the source.
  [[nodiscard]] bool is_identified() const noexcept {
    return course_.time() > shortest_ && span_.highest_seen - span_.lowest_seen < T(0.1) &&
           !(span_.lowest_speed < -slowest() && span_.highest_speed > slowest());
  }

  /// ω_r below which the shaft counts as still: the share of the measured flux is 6 % there. [rad/s]
  [[nodiscard]] T slowest() const noexcept { return T(0.5) * low_; }

  /// Of the identified R_s: at high speed a small angle between current and flux counts as resistance. [-]
  [[nodiscard]] T stator_weight() const noexcept {
    const T ratio = omega_r_.value() / high_;
    return T(1) / (T(1) + ratio * ratio);
  }

  /// Over the course: share of the measured flux [-] and filtered ω_r [rad/s].
  struct Span {
    T lowest_seen{T(1)};
    T highest_seen{T(0)};
    T lowest_speed{std::numeric_limits<T>::infinity()};
    T highest_speed{-std::numeric_limits<T>::infinity()};

    void add(T seen, T omega_r) noexcept {
      lowest_seen = std::min(lowest_seen, seen);
      highest_seen = std::max(highest_seen, seen);
      lowest_speed = std::min(lowest_speed, omega_r);
      highest_speed = std::max(highest_speed, omega_r);
    }
  };

  /// By how much φ exceeds that of the current model φ_m, by least squares over the filter time of
  ///   y = ω_r (φ − φ_m),   φ − φ_m = Σ ω_r y/Σ ω_r²,
  /// with y the voltage across the flux less ω_r φ_m. It is a mean, weighted by ω_r², and finite where the
  /// speed passes through zero. Both stages have half the filter time.
  class FluxError {
   public:
    void begin(T omega_r) noexcept {
      voltage_ = product_ = T(0);
      omega_r_ = omega_r;
      square_ = omega_r * omega_r;
    }
    void step(T voltage, T omega_r, T k) noexcept {
      voltage_ += k * (voltage - voltage_);
      omega_r_ += k * (omega_r - omega_r_);
      product_ += k * (omega_r_ * voltage_ - product_);
      square_ += k * (omega_r_ * omega_r_ - square_);
    }
    /// Meaningful where the square is above zero. [Wb]
    [[nodiscard]] T value() const noexcept { return product_ / square_; }
    /// Filtered ω_r². [rad²/s²]
    [[nodiscard]] T square() const noexcept { return square_; }

   private:
    T voltage_{};  ///< y [V]
    T omega_r_{};  ///< [rad/s]
    T product_{};  ///< ω_r y [V·rad/s]
    T square_{};   ///< [rad²/s²]
  };

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
  T voltage_error_;       ///< [V]
  T low_;                 ///< ω_r above which φ is measured [rad/s]
  T high_;                ///< ω_r above which R_s is not identified [rad/s]
  LowPass along_{};       ///< voltage along the flux [V]
  FluxError error_{};     ///< by the voltage across the flux
  LowPass current_{};     ///< [A]
  LowPass model_flux_{};  ///< [Wb]
  LowPass omega_r_{};     ///< [rad/s]
  T flux_{};              ///< [Wb]
  T lag_{};               ///< of the current model behind its filter [Wb]
  T time_{};              ///< [s]
  T seen_{};              ///< share of the measured flux in φ [-]
  Span span_{};
  FluxCourse<T> course_;
  StandstillCourse<T> standstill_;
  ParameterCovariance<T> covariance_{};
  bool has_found_{false};
};

}  // namespace sextant
