#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "sextant/control/controller.hpp"
#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/measurement.hpp"

namespace sextant {

/// One control period as a controller gets it.
template <class T>
struct ControlPeriod {
  Measurement<T> measurement{};
  ControlReference<T> reference{};
};

/// How far the values of `RandomPeriods` reach.
enum class InputRange : std::uint8_t {
  plausible,  ///< those of a drive: 500 A, 800 V, 500 rad/s, 200 N·m
  extreme     ///< any that protections let pass and more: 1e6 A, 1e5 V, 1e5 rad/s, 1e6 N·m; zeros, denormals
};

/// Measurements and references at random, the same for the same seed. Modes last for some periods, as those
/// of a drive do; the applied pattern has none to eight segments, legs off among them.
template <class T>
class RandomPeriods {
 public:
  RandomPeriods(std::uint64_t seed, InputRange range, std::int32_t period_ns)
      : random_{seed}, range_{range}, period_ns_{period_ns} {}

  [[nodiscard]] ControlPeriod<T> next() {
    if (below(20) == 0) mode_ = ControlMode{std::uint8_t(below(3))};
    ControlPeriod<T> p;
    p.measurement.i_abc = {value(T(500), T(1e6)), value(T(500), T(1e6)), value(T(500), T(1e6))};
    p.measurement.u_dc = std::abs(value(T(800), T(1e5)));
    p.measurement.omega_m = value(T(500), T(1e5));
    p.measurement.applied = pattern();
    if (below(2) == 0)
      p.measurement.theta_m = T(std::uniform_real_distribution<double>{-3.14, 3.14}(random_));
    p.reference = {mode_, value(T(200), T(1e6)), flux_share()};
    return p;
  }

 private:
  [[nodiscard]] std::uint64_t below(std::uint64_t n) {
    return std::uniform_int_distribution<std::uint64_t>{0, n - 1}(random_);
  }

  [[nodiscard]] T value(T plausible, T extreme) {
    if (range_ == InputRange::plausible) return between(plausible);
    switch (below(6)) {
      case 0:
        return T(0);
      case 1:
        return std::numeric_limits<T>::denorm_min();
      case 2:
        return -std::numeric_limits<T>::min();
      case 3:
        return below(2) == 0 ? extreme : -extreme;
      case 4:
        return between(plausible);
      default:
        return between(extreme);
    }
  }
  [[nodiscard]] T between(T limit) {
    return T(std::uniform_real_distribution<double>{-double(limit), double(limit)}(random_));
  }

  /// 1 as often as not, as a drive asks for it below its base speed.
  [[nodiscard]] T flux_share() {
    const T least = range_ == InputRange::plausible ? T(0.1) : T(1e-3);
    return below(2) == 0 ? T(1) : T(std::uniform_real_distribution<double>{double(least), 1.0}(random_));
  }

  [[nodiscard]] SwitchState state() {
    if (below(8) == 0) return gates_off;
    if (below(16) == 0) return {LegState::off, LegState::high, LegState::low};
    return switch_states[below(8)];
  }

  /// Of one period, or, after missed ones, of several; of none where nothing has been applied.
  [[nodiscard]] GatePattern pattern() {
    if (below(16) == 0) return below(2) == 0 ? GatePattern{} : GatePattern{state(), 0};
    std::int64_t left_ns = below(16) == 0 ? std::int64_t(below(40)) * period_ns_ : period_ns_;
    GatePattern pattern;
    for (std::uint64_t k = below(GatePattern::capacity); k > 0; --k) {
      const auto part_ns = std::int64_t(below(std::uint64_t(left_ns) + 1));
      pattern.append({state(), std::int32_t(part_ns)});
      left_ns -= part_ns;
    }
    pattern.append({state(), std::int32_t(left_ns)});
    return pattern;
  }

  std::mt19937_64 random_;
  InputRange range_;
  std::int32_t period_ns_;
  ControlMode mode_{ControlMode::off};
};

}  // namespace sextant
