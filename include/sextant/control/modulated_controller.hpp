#pragma once

#include "sextant/control/current_reference.hpp"
#include "sextant/control/estimating_controller.hpp"

namespace sextant {

/// What the controllers share that demand a voltage and leave the switching to a `SpaceVectorModulator`. A
/// method adds how the voltage follows from flux, current and references.
template <class T = double>
class ModulatedController : public EstimatingController<T> {
 public:
  struct Parameters : EstimatingController<T>::Parameters {
    T current_limit{T(250)};  ///< of the stator current that torque and flux may take [A]
    typename SpaceVectorModulator<T>::Parameters modulator{};

    void set_basis(const ControlBasis<T>& basis) noexcept {
      EstimatingController<T>::Parameters::set_basis(basis);
      current_limit = basis.current_limit;
    }

    friend void describe(Description& d, Parameters& p, const Parameters& by_default) {
      describe(d, p.magnetiser, by_default.magnetiser);
      describe(d, p.modulator);
    }

    [[nodiscard]] const char* validate() const noexcept {
      if (const char* problem = EstimatingController<T>::Parameters::validate()) return problem;
      if (const char* problem = modulator.validate()) return problem;
      return validate_current_limit(current_limit, this->machine, this->flux_reference);
    }
  };

  explicit ModulatedController(const Parameters& parameters) noexcept
      : Base{parameters, parameters.modulator}, current_limit_{parameters.current_limit} {}

  [[nodiscard]] bool holds_mean_torque() const noexcept final { return true; }
  [[nodiscard]] bool reaches_six_step() const noexcept final { return Base::holds_fundamental(); }

  [[nodiscard]] bool takes_parameters() const noexcept final { return true; }
  void take_parameters(const Controller<T>& from) noexcept SEXTANT_NONBLOCKING override {
    Base::take_parameters(from);
    current_limit_ = static_cast<const ModulatedController&>(from).current_limit_;
  }

 protected:
  using typename EstimatingController<T>::Demand;

  /// The stator voltage of a period in which the torque follows its reference, which the modulator limits to
  /// the hexagon. [V]
  [[nodiscard]] virtual SpaceVector<T> voltage(const Demand& demand) noexcept SEXTANT_NONBLOCKING = 0;
  [[nodiscard]] CurrentDemand<T> current_demand(const Demand& d) const noexcept {
    return {d.torque, d.psi_ref, current_limit_};
  }

 private:
  using Base = EstimatingController<T>;

  [[nodiscard]] GatePattern follow(const Demand& demand) noexcept SEXTANT_NONBLOCKING final {
    return Base::modulate(voltage(demand), demand.u_dc);
  }

  T current_limit_;  ///< [A]
};

}  // namespace sextant
