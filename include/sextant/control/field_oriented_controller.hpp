#pragma once

#include "sextant/control/bandwidth.hpp"
#include "sextant/control/current_reference.hpp"
#include "sextant/control/modulated_controller.hpp"

namespace sextant {

/// Field-oriented control with space-vector modulation: the current follows its reference along and across
/// the estimated rotor flux. With `FluxEstimatorKind::current_model` that is indirect field orientation, with
/// the kinds that use the stator voltage direct field orientation. The current controller is a complex-vector
/// PI controller, made for the sampled machine, with feed-forward of the voltage e that the rotor flux
/// induces. In the frame of the rotor flux, whose angle grows by φ = ω_e t_period in the period,
///   u = e + G e^{jφ} (i* − i) + v,   v[k+1] = a e^{−jφ} v + (1 − a e^{−jφ}) (u_real − e)
///   e = k_r (j p ω_m − 1/τ_r) ψ_r,   G = (1 − e^{−α t_period})/b
///   a = (σL_s − R t_period/2)/(σL_s + R t_period/2),   b = t_period/(σL_s + R t_period/2),   R = R_s + k_r²
///   R_r
/// Within the hexagon v is the integral of G (e^{jφ} − a)(i* − i), whose zero meets the pole of the machine
/// at every speed, so that the current follows with 1/(1 + s/α). Beyond it v follows the realised voltage
/// u_real, as if the reference had been the current that this voltage leads to: no integral winds up.
/// Sources: F. Blaschke, "The principle of field orientation as applied to the new TRANSVECTOR closed-loop
/// control system for rotating-field machines", Siemens Review 34 (1972) 217–220; F. Briz, M. W. Degner,
/// R. D. Lorenz, "Analysis and design of current regulators using complex vectors", IEEE Trans. Ind. Appl. 36
/// (2000) 817–825; for the sampled machine H. Kim, M. W. Degner, J. M. Guerrero, F. Briz, R. D. Lorenz,
/// "Discrete-time current regulator design for AC machine drives", IEEE Trans. Ind. Appl. 46 (2010)
/// 1425–1435.
template <class T = double>
class FieldOrientedController final : public ModulatedController<T> {
 public:
  static constexpr const char* name = "foc";
  static constexpr const char* meaning = "field-oriented control with space-vector modulation";

  struct Parameters : BandwidthParameters<T> {
    friend void describe(Description& d, Parameters& p, const Parameters& by_default) {
      p.describe_with(d, by_default,
                      "bandwidth with which the current follows its reference; by default 0.2, at most 0.5, "
                      "divided by the control period");
    }
  };

  explicit FieldOrientedController(const Parameters& parameters) noexcept
      : ModulatedController<T>{parameters}, approach_{parameters.approach()} {}

  void take_parameters(const Controller<T>& from) noexcept SEXTANT_NONBLOCKING override {
    ModulatedController<T>::take_parameters(from);
    approach_ = static_cast<const FieldOrientedController&>(from).approach_;
  }

 private:
  using Base = ModulatedController<T>;
  using typename Base::Demand;

  /// The machine in the coming period, in the frame of its rotor flux at the beginning.
  struct Frame {
    SpaceVector<T> along;  ///< direction of ψ_r at the beginning, stationary frame
    SpaceVector<T> turn;   ///< e^{jφ}
    SpaceVector<T> emf;    ///< mean of e, stationary frame [V]
    T psi_r;               ///< at the beginning [Wb]
    T decay;               ///< a [-]
    T per_volt;            ///< b [A/V]
  };

  [[nodiscard]] SpaceVector<T> voltage(const Demand& demand) noexcept SEXTANT_NONBLOCKING override {
    const Frame frame = frame_of(demand.x);
    const SpaceVector<T> i_s = product(conjugate(frame.along), demand.x.i_s);
    const SpaceVector<T> pole{frame.turn.alpha - frame.decay, frame.turn.beta};  // e^{jφ} − a
    if (!is_closed_) integral_ = (T(1) / frame.per_volt) * product(pole, i_s);   // what keeps the current
    is_closed_ = true;
    const SpaceVector<T> wanted =
        current_reference(Base::estimator().machine(), frame.psi_r, Base::current_demand(demand));
    const SpaceVector<T> proportional = (approach_ / frame.per_volt) * product(frame.turn, wanted - i_s);
    const SpaceVector<T> u = frame.emf + product(frame.along, proportional + integral_);
    update_integral(frame, pole, Base::realised(u, demand.u_dc));
    return u;
  }

  void release() noexcept SEXTANT_NONBLOCKING override { is_closed_ = false; }

  /// v at the end of the period in which u_real is realised [V].
  void update_integral(const Frame& frame, SpaceVector<T> pole, SpaceVector<T> u_real) noexcept {
    const SpaceVector<T> rest = product(conjugate(frame.along), u_real - frame.emf) - integral_;
    integral_ += product(conjugate(frame.turn), product(pole, rest));
  }

  [[nodiscard]] Frame frame_of(const FluxAndCurrent<T>& x) const noexcept {
    const FluxTorqueEstimator<T>& estimator = Base::estimator();
    const InductionMachineParameters<T>& machine = estimator.machine();
    const CurrentModel<T>& model = estimator.current_model();
    const T dt = Base::period();
    const SpaceVector<T> psi_r = model.psi_r_from(x.psi_s, x.i_s);
    const SpaceVector<T> end = psi_r + dt * model.derivative(psi_r, x.i_s, estimator.omega_m());
    const SpaceVector<T> along = direction(psi_r);
    const T damping = T(0.5) * dt * (machine.r_s + machine.k_r() * machine.k_r() * machine.r_r);
    const T inertia = T(1) / (machine.sigma_l_s() + damping);
    return {.along = along,
            .turn = product(conjugate(along), direction(end)),
            .emf = machine.k_r() * model.derivative(T(0.5) * (psi_r + end), {}, estimator.omega_m()),
            .psi_r = magnitude(psi_r),
            .decay = inertia * (machine.sigma_l_s() - damping),
            .per_volt = inertia * dt};
  }

  [[nodiscard]] static constexpr SpaceVector<T> conjugate(SpaceVector<T> x) noexcept {
    return {x.alpha, -x.beta};
  }

  T approach_;                 ///< 1 − e^{−α t_period} [-]
  SpaceVector<T> integral_{};  ///< v, in the frame of the rotor flux [V]
  bool is_closed_{false};      ///< v continues the period before
};

}  // namespace sextant
