#pragma once

#include "sextant/control/deadbeat_voltage.hpp"
#include "sextant/control/modulated_controller.hpp"

namespace sextant {

/// Deadbeat direct torque and flux control with space-vector modulation: the modulator realises the voltage
/// with which torque and stator flux meet their references at the end of the coming period
/// (`deadbeat_voltage`).
template <class T = double>
class DeadbeatController final : public ModulatedController<T> {
 public:
  static constexpr const char* name = "deadbeat";
  static constexpr const char* meaning = "deadbeat direct torque control with space-vector modulation";

  struct Parameters : ModulatedController<T>::Parameters {};

  explicit DeadbeatController(const Parameters& parameters) noexcept : ModulatedController<T>{parameters} {}

 private:
  using Base = ModulatedController<T>;
  using typename Base::Demand;

  [[nodiscard]] SpaceVector<T> voltage(const Demand& demand) noexcept SEXTANT_NONBLOCKING override {
    return deadbeat_voltage(Base::estimator(), demand.x, Base::current_demand(demand), Base::period());
  }
};

}  // namespace sextant
