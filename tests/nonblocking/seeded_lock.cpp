// Seeded violation: a controller that locks three calls below its step. scripts/check_function_effects
// --self-test must find it.
#include <mutex>

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
    const std::lock_guard hold{mutex_};
    torque_ = reference.torque;
  }

  std::mutex mutex_{};
  double torque_{};
};

}  // namespace sextant
