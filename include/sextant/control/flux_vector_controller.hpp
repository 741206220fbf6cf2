#pragma once

#include "sextant/control/deadbeat_voltage.hpp"
#include "sextant/control/estimating_controller.hpp"
#include "sextant/control/torque_trim.hpp"

namespace sextant {

/// What the controllers share that choose, of a set of patterns, the one that leads the stator flux vector
/// nearest to its reference at the end of the coming period. With  ψ_s[k+1] = ψ_s + t_period (u − R_s i_s)
/// that is the pattern whose mean voltage u is nearest to `deadbeat_voltage`. The vector stands for torque
/// and flux at once, so that no weighting factor compares their errors. What no pattern of the set realises
/// is left for the next period; the trim takes its mean out of the torque. A method adds the set. Source: Y.
/// Zhang, H. Yang, B. Xia, "Model-predictive control of induction motor drives: torque control versus flux
/// control", IEEE Trans. Ind. Appl. 52 (2016) 4050–4060.
template <class T = double>
class FluxVectorController : public EstimatingController<T> {
 public:
  struct Parameters : EstimatingController<T>::Parameters {
    T current_limit{T(250)};  ///< of the stator current that torque and flux may take [A]
    typename TorqueTrim<T>::Parameters torque_trim{};

    void set_basis(const ControlBasis<T>& basis) noexcept {
      EstimatingController<T>::Parameters::set_basis(basis);
      current_limit = basis.current_limit;
    }

    friend void describe(Description& d, Parameters& p, const Parameters& by_default) {
      describe(d, p.magnetiser, by_default.magnetiser);
      describe(d, p.torque_trim);
    }

    [[nodiscard]] const char* validate() const noexcept {
      if (const char* problem = EstimatingController<T>::Parameters::validate()) return problem;
      if (const char* problem = torque_trim.validate()) return problem;
      return validate_current_limit(current_limit, this->machine, this->flux_reference);
    }
  };

  /// Without the trim the mean torque is below its reference by what the patterns of the set leave.
  [[nodiscard]] bool holds_mean_torque() const noexcept final { return torque_trim_.trims(); }

  [[nodiscard]] bool takes_parameters() const noexcept final { return true; }
  void take_parameters(const Controller<T>& from) noexcept SEXTANT_NONBLOCKING final {
    Base::take_parameters(from);
    const auto& other = static_cast<const FluxVectorController&>(from);
    current_limit_ = other.current_limit_;
    torque_trim_.take_parameters(other.torque_trim_);
  }

 protected:
  using typename EstimatingController<T>::Demand;

  explicit FluxVectorController(const Parameters& parameters) noexcept
      : Base{parameters},
        current_limit_{parameters.current_limit},
        torque_trim_{parameters.torque_trim, parameters.machine, Base::period()} {}

  /// The pattern of the set whose mean voltage is nearest to u [V]. It must call `drive`. quantum: that of
  /// `EstimatingController::vector_quantum`. [-]
  [[nodiscard]] virtual GatePattern realise(SpaceVector<T> u, T u_dc,
                                            T quantum) noexcept SEXTANT_NONBLOCKING = 0;

  void release() noexcept SEXTANT_NONBLOCKING final { torque_trim_.reset(); }

 private:
  using Base = EstimatingController<T>;

  [[nodiscard]] GatePattern follow(const Demand& d) noexcept SEXTANT_NONBLOCKING final {
    const T torque = torque_trim_.step(d.torque, Base::estimate_.torque, d.psi_ref, d.u_dc, Base::rests());
    const CurrentDemand<T> demand{torque, d.psi_ref, current_limit_};
    return realise(deadbeat_voltage(Base::estimator(), d.x, demand, Base::period()), d.u_dc,
                   Base::vector_quantum(d.psi_ref, d.u_dc));
  }

  T current_limit_;  ///< [A]
  TorqueTrim<T> torque_trim_;
};

}  // namespace sextant
