// Seeded violation: a controller that throws three calls below its step. scripts/check_function_effects
// --self-test must find it.
#include <stdexcept>

#include "sextant/control/controller.hpp"

namespace sextant {

class SeededController final : public Controller<double> {
 public:
  [[nodiscard]] GatePattern step(const Measurement<double>& measurement,
                                 ControlReference<double> reference) noexcept SEXTANT_NONBLOCKING override {
    return decide(measurement, reference);
  }
  void reset() noexcept SEXTANT_NONBLOCKING override {}

 private:
  GatePattern decide(const Measurement<double>&, const ControlReference<double>& reference) {
    remember(reference);
    return {};
  }
  void remember(const ControlReference<double>& reference) {
    if (reference.torque > 100.0) throw std::runtime_error("too much torque");
  }
};

}  // namespace sextant
