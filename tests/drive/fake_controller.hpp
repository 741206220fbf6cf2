#pragma once

#include <cstdint>

#include "sextant/control/controller.hpp"

namespace sextant::test {

/// Records what the drive asks of it; its estimate is what the test sets.
template <class T>
class FakeController final : public Controller<T> {
 public:
  FakeController() noexcept { this->estimate_.magnetised = true; }
  [[nodiscard]] GatePattern step(const Measurement<T>& measurement,
                                 ControlReference<T> reference) noexcept override {
    ++steps;
    last_measurement = measurement;
    last_reference = reference;
    const bool on = reference.mode != ControlMode::off;
    return GatePattern{on ? switch_states[1] : gates_off, pattern_ns};
  }
  [[nodiscard]] ControlEstimate<T>& estimate() noexcept { return this->estimate_; }
  void reset() noexcept override { ++resets; }
  void restart() noexcept override { ++restarts; }
  [[nodiscard]] bool holds_mean_torque() const noexcept override { return holds; }

  std::int32_t pattern_ns{25'000};  ///< length of its patterns [ns]
  bool holds{true};                 ///< its mean torque
  int steps{0};
  int resets{0};
  int restarts{0};
  Measurement<T> last_measurement{};
  ControlReference<T> last_reference{};
};

}  // namespace sextant::test
