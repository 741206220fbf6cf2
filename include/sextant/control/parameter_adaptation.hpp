#pragma once

#include <algorithm>

#include "sextant/control/hybrid_flux_model.hpp"
#include "sextant/control/parameter_covariance.hpp"
#include "sextant/control/parameter_prior.hpp"
#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Adapts R_s, R_r and L_m while torque is made, by the factor c of `HybridFluxModel` between the stator
/// fluxes of the voltage model and of the current model. With δ, by how much the machine's parameters exceed
/// those in use, as shares of these, to first order and at constant leakage inductances,
///   c − 1 = H_s δ_s + H_r δ_r + H_L δ_L
/// By how much the machine's rotor flux exceeds that of the current model, for δ_r = 1 and for δ_L = 1:
///   τ_r dh_r/dt = z − 1 − z h_r − κ Re h_r,   τ_r dh_L/dt = 1 − z h_L − κ Re h_L,   z = L_m i_s/ψ_r
/// κ is the steepness of a known saturation (`SaturationCurve`), else zero.
/// By how much the stator flux of the voltage model exceeds the machine's, for δ_s = 1, at a steady
/// frequency:
///   h_s = R_s i_s/(jω_e ψ_s)
/// and for a voltage error of 1 V along the current
///   h_u = i_s/|i_s|/(jω_e ψ_s)
/// H_s, H_r and H_L are h_s and the shares k_r ψ_r/ψ_s of h_r and h_L behind the filter that c passes, so
/// that the equation also holds after steps of the torque, and where c returns to 1. c has two components and
/// there are three parameters. An update follows c by the gain that leaves the least of what remains unknown
/// of the parameters (`ParameterCovariance::gain`): what magnetising has left open, R_s against L_m at
/// standstill, c closes as soon as it shows the flux. This gain falls with what is unknown. Where the
/// gradient of |c − 1 − H δ|² takes up more of c, weighted by the covariance of `ParameterPrior` and divided
/// by the variance of c, that of the prior and that of its error together, it is the gain: a machine that
/// changes is followed at its rate. The parameters converge where the torque changes. Both models take over
/// what they have of the errors that an update takes away (`Correction`): h_r δ_r + h_L δ_L of the rotor
/// flux, H δ of c. The error of c is that of the sensors' gains, alike for the flux and for the resistive
/// voltage, that of an unknown voltage along the current, by h_u behind the same filter, and that of a wrong
/// initial flux, which decays with τ_r. Parameters that magnetising has
/// identified fit the flux with which it ends: it is wrong by h_r δ_r + h_L δ_L, which have followed its
/// current, and by nothing else. Source of
/// the principle, a voltage model as reference for a current model that is adapted: C. Schauder, "Adaptive
/// speed identification for vector control of induction motors without rotational transducers", IEEE Trans.
/// Ind. Appl. 28 (1992) 1054–1061; of the gradient along sensitivities: L. Ljung, System Identification,
/// Upper Saddle River 1999, chapter 11.
///
/// What remains unknown of the parameters (`ParameterCovariance`) follows from the same sensitivities and
/// gains; errors of c last for some τ_r, which is as many updates.
template <class T = double>
class ParameterAdaptation {
 public:
  using Machine = InductionMachineParameters<T>;
  using Rates = typename HybridFluxModel<T>::Rates;

  /// What both models show at an instant.
  struct Evidence {
    SpaceVector<T> excess;  ///< c − 1 [-]
    Rates rates;            ///< of c [1/s]
    SpaceVector<T> i_s;     ///< [A]
    SpaceVector<T> psi_r;   ///< of the current model [Wb]
    SpaceVector<T> psi_s;   ///< [Wb]
    Machine present;        ///< the machine at this flux
    T steepness;            ///< of its saturation there (`SaturationCurve`) [-]
  };

  /// What the models have of errors of the parameters, by those that an update has taken away.
  struct Correction {
    SpaceVector<T> psi_r;   ///< by how much the machine's rotor flux exceeds the current model's, of that [-]
    SpaceVector<T> excess;  ///< in c [-]
  };

  /// From the parameters as configured. voltage_error: standard deviation of the stator voltage along the
  /// current. [V]
  constexpr ParameterAdaptation(const Machine& configured, T voltage_error) noexcept
      : configured_{configured}, voltage_variance_{voltage_error * voltage_error} {}

  /// Counts a period of dt [s]; true where `update` is due.
  [[nodiscard]] bool count(T dt) noexcept {
    time_ += dt;
    return time_ >= update_time;
  }

  /// The parameters of a machine after the time counted.
  [[nodiscard]] Machine update(Machine machine, const Evidence& seen) noexcept {
    const T share = time_ / seen.present.tau_r();
    const bool has_flux = follow(seen, share);
    time_ = T(0);
    correction_ = {};
    if (!has_flux) return machine;
    const T error = Prior::gain_error * Prior::gain_error * (T(1) + dot(by_r_s_, by_r_s_)) +
                    voltage_variance_ * dot(by_voltage_, by_voltage_) + start_variance_;
    const SpaceVector<T> for_r_s = r_s_variance * by_r_s_ + warming_variance * by_r_r_;
    const SpaceVector<T> for_r_r = r_r_variance * by_r_r_ + warming_variance * by_r_s_;
    const SpaceVector<T> for_l = l_variance * by_l_;
    const T step = rate * share / (dot(by_r_s_, for_r_s) + dot(by_r_r_, for_r_r) + dot(by_l_, for_l) + error);
    const Rows seen_by{by_r_s_, by_r_r_, by_l_};
    const T variance = T(2) * error / share;
    const Rows known{step * for_r_s, step * for_r_r, step * for_l};
    const Rows best = covariance_.gain(seen_by, variance);
    const Rows& gain = trace(seen_by, best) > trace(seen_by, known) ? best : known;
    covariance_.observe(seen_by, gain, variance);
    const Machine before = machine;
    machine.r_s = moved(machine.r_s, dot(gain.s, seen.excess), configured_.r_s);
    machine.r_r = moved(machine.r_r, dot(gain.r, seen.excess), configured_.r_r);
    machine.l_m = moved(machine.l_m, dot(gain.l, seen.excess), configured_.l_m);
    correct(machine.r_s / before.r_s - T(1), machine.r_r / before.r_r - T(1),
            machine.l_m / before.l_m - T(1));
    return machine;
  }

  /// To be taken over by the models after an update.
  [[nodiscard]] constexpr const Correction& correction() const noexcept { return correction_; }

  /// The factor is 1 again: both models start from the same flux, which may be wrong.
  void reset() noexcept {
    rotor_by_r_r_ = rotor_by_l_ = by_r_s_ = by_voltage_ = by_r_r_ = by_l_ = {};
    start_variance_ = initial_variance;
    time_ = T(0);
  }

  /// A time counted in which the machine is magnetised by i_s [A]; psi_r: of the current model [Wb].
  /// machine and steepness: at the present flux, as in `Evidence`.
  void magnetise(const Machine& machine, SpaceVector<T> i_s, SpaceVector<T> psi_r, T steepness) noexcept {
    const T rotor = dot(psi_r, psi_r);
    if (rotor > least_flux_squared) {
      follow_rotor(machine, i_s, psi_r, rotor, time_ / machine.tau_r(), steepness);
    }
    time_ = T(0);
  }
  /// Magnetising has ended with parameters and flux that fit its currents: the flux is wrong by what the
  /// parameters are wrong by, and by nothing else. The factor is 1 again.
  void begin_identified() noexcept {
    const SpaceVector<T> by_r_r = rotor_by_r_r_;
    const SpaceVector<T> by_l = rotor_by_l_;
    reset();
    rotor_by_r_r_ = by_r_r;
    rotor_by_l_ = by_l;
    start_variance_ = T(0);
  }

  /// What remains unknown of the parameters in use.
  [[nodiscard]] constexpr const ParameterCovariance<T>& covariance() const noexcept { return covariance_; }
  /// Something else than this adaptation has changed them: what it leaves unknown.
  constexpr void set(const ParameterCovariance<T>& covariance) noexcept { covariance_ = covariance; }
  /// The parameters about which those in use have their bounds.
  constexpr void set_configured(const Machine& configured) noexcept { configured_ = configured; }
  /// dt [s] in which the machine may warm or cool.
  constexpr void age(T dt) noexcept { covariance_.age(dt); }

 private:
  using Prior = ParameterPrior<T>;
  using Rows = typename ParameterCovariance<T>::Rows;
  static constexpr T update_time = T(1e-3);         ///< [s]
  static constexpr T rate = T(0.1);                 ///< largest of the update, as a multiple of 1/τ_r [-]
  static constexpr T least_flux_squared = T(1e-6);  ///< with which c means something [Wb²]
  static constexpr T initial_variance = T(10);      ///< of c, by a wrong initial flux [-]
  static constexpr T r_s_variance = Prior::r_s_deviation * Prior::r_s_deviation;
  static constexpr T r_r_variance = Prior::r_r_deviation * Prior::r_r_deviation;
  static constexpr T warming_variance = Prior::warming * Prior::warming;
  static constexpr T l_variance = Prior::l_deviation * Prior::l_deviation;

  /// Advances h and H by the time counted, `share` of τ_r; false without flux.
  [[nodiscard]] bool follow(const Evidence& seen, T share) noexcept {
    const Machine& machine = seen.present;
    const T rotor = dot(seen.psi_r, seen.psi_r);
    const T stator = dot(seen.psi_s, seen.psi_s);
    if (!(rotor > least_flux_squared && stator > least_flux_squared)) return false;
    follow_rotor(machine, seen.i_s, seen.psi_r, rotor, share, seen.steepness);
    start_variance_ /= T(1) + share;
    const Rates& r = seen.rates;
    const T decay = r.follow + r.leak;
    const auto by_frequency = [&seen, stator](T volts, SpaceVector<T> x) {
      const T drop = volts / stator;
      return SpaceVector<T>{drop * cross(seen.psi_s, x), -drop * dot(seen.psi_s, x)};
    };
    by_r_s_ += time_ * (r.by_frequency * by_frequency(machine.r_s, seen.i_s) - decay * by_r_s_);
    by_voltage_ += time_ * (r.by_frequency * by_frequency(T(1), direction(seen.i_s)) - decay * by_voltage_);
    const T main_scale = machine.k_r() / stator;
    const SpaceVector<T> main_share{main_scale * dot(seen.psi_s, seen.psi_r),
                                    main_scale * cross(seen.psi_s, seen.psi_r)};
    by_r_r_ += time_ * (r.follow * product(main_share, rotor_by_r_r_) - decay * by_r_r_);
    by_l_ += time_ * (r.follow * product(main_share, rotor_by_l_) - decay * by_l_);
    return true;
  }

  /// Advances h_r and h_L by a share of τ_r; rotor: |ψ_r|². [Wb²]
  void follow_rotor(const Machine& machine, SpaceVector<T> i_s, SpaceVector<T> psi_r, T rotor, T share,
                    T steepness) noexcept {
    const T z_scale = machine.l_m / rotor;
    // A current against the flux, which passes, is left out: it would make the errors grow without bound.
    const SpaceVector<T> z{z_scale * std::max(T(0), dot(psi_r, i_s)), z_scale * cross(psi_r, i_s)};
    const SpaceVector<T> one{T(1), T(0)};
    // One implicit step each, because z has no bound where the flux is small.
    const SpaceVector<T> implicit = one + share * z;
    rotor_by_r_r_ = quotient(rotor_by_r_r_ + share * (z - one), implicit);
    rotor_by_l_ = quotient(rotor_by_l_ + share * one, implicit);
    // Where the iron saturates more flux takes the more current.
    const T along = T(1) + share * steepness;
    rotor_by_r_r_.alpha /= along;
    rotor_by_l_.alpha /= along;
  }

  /// The parameters have followed by these shares.
  void correct(T r_s, T r_r, T l_m) noexcept {
    correction_ = {.psi_r = r_r * rotor_by_r_r_ + l_m * rotor_by_l_,
                   .excess = r_s * by_r_s_ + r_r * by_r_r_ + l_m * by_l_};
  }

  /// Share of an observation that its own estimate takes up with this gain: trace of H K. [-]
  [[nodiscard]] static constexpr T trace(const Rows& h, const Rows& k) noexcept {
    return dot(h.s, k.s) + dot(h.r, k.r) + dot(h.l, k.l);
  }

  [[nodiscard]] static constexpr T moved(T value, T change, T configured) noexcept {
    return Prior::bounded(value * (T(1) + change), configured);
  }

  Machine configured_;
  T voltage_variance_;  ///< of the stator voltage along the current [V²]
  ParameterCovariance<T> covariance_{};
  T time_{};                            ///< since the last update [s]
  SpaceVector<T> rotor_by_r_r_{};       ///< h_r [-]
  SpaceVector<T> rotor_by_l_{};         ///< h_L [-]
  SpaceVector<T> by_r_s_{};             ///< H_s [-]
  SpaceVector<T> by_voltage_{};         ///< H_u [1/V]
  SpaceVector<T> by_r_r_{};             ///< H_r [-]
  SpaceVector<T> by_l_{};               ///< H_L [-]
  Correction correction_{};             ///< of the last update
  T start_variance_{initial_variance};  ///< of c, by the initial flux [-]
};

}  // namespace sextant
