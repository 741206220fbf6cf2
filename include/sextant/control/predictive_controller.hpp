#pragma once

#include "sextant/control/flux_vector_controller.hpp"

namespace sextant {

/// Finite-control-set predictive torque control without weighting factor: one switching state a period, the
/// one whose voltage is nearest to that which leads torque and stator flux to their references. Where a whole
/// period of an active one moves the current too far for the machine to be magnetised, multiples of a part of
/// it (`MagnetisingControl::vector_quantum`) are in the set, with a zero vector for the rest. Sources: as
/// `FluxVectorController`; V. P. Muddineni, S. R. Sandepudi, A. K. Bonala, "Simplified finite control set
/// model predictive control for induction motor drive without weighting factors", PEDES 2016 (paper, [10]).
template <class T = double>
class PredictiveController final : public FluxVectorController<T> {
 public:
  static constexpr const char* name = "predictive";
  static constexpr const char* meaning = "predictive torque control, one switching state a period";

  struct Parameters : FluxVectorController<T>::Parameters {
    /// With vectors that act for whole periods the time constant of the trim follows from what they change.
    void set_defaults(const ControlBasis<T>& basis) noexcept {
      FluxVectorController<T>::Parameters::set_defaults(basis);
      this->torque_trim.time_constant =
          default_trim_time(basis.flux_reference, basis.u_dc, T(basis.period_ns) * T(1e-9));
    }

    friend void describe(Description& d, Parameters& p, const Parameters& by_default) {
      describe(d, p.magnetiser, by_default.magnetiser);
      describe(d, p.torque_trim, by_default.torque_trim);
    }
  };

  explicit PredictiveController(const Parameters& parameters) noexcept : Base{parameters} {}

 private:
  using Base = FluxVectorController<T>;

  [[nodiscard]] GatePattern realise(SpaceVector<T> u, T u_dc,
                                    T quantum) noexcept SEXTANT_NONBLOCKING override {
    return Base::nearest(u, u_dc, quantum);
  }
};

}  // namespace sextant
