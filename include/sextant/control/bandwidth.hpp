#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/control/modulated_controller.hpp"

namespace sextant {

/// 0.2/t_period, of a period [ns]. [rad/s]
template <class T>
[[nodiscard]] constexpr T default_bandwidth(std::int32_t period_ns) noexcept {
  return T(0.2e9) / T(period_ns);
}

/// Parameters of a modulated method whose quantities follow their references with 1/(1 + s/α).
template <class T>
struct BandwidthParameters : ModulatedController<T>::Parameters {
  T bandwidth{default_bandwidth<T>(25'000)};  ///< α [rad/s]

  void set_defaults(const ControlBasis<T>& basis) noexcept {
    ModulatedController<T>::Parameters::set_defaults(basis);
    bandwidth = default_bandwidth<T>(basis.period_ns);
  }

  friend void describe(Description& d, BandwidthParameters& p, const BandwidthParameters& by_default) {
    p.describe_with(d, by_default,
                    "bandwidth with which torque and stator flux follow their references; by default 0.2, at "
                    "most 0.5, divided by the control period");
  }
  /// meaning: of the bandwidth.
  void describe_with(Description& d, const BandwidthParameters& by_default, const char* meaning) {
    d.defaulted("bandwidth_rad_s", bandwidth, by_default.bandwidth,
                {"rad/s", 1, 1e6, meaning, Changes::always});
    typename ModulatedController<T>::Parameters& modulated = *this;
    describe(d, modulated, by_default);
  }

  /// At most 0.5/t_period: with a machine of half the leakage inductance the gain of the loop doubles, and
  /// the quantity still converges.
  [[nodiscard]] const char* validate() const noexcept {
    if (const char* problem = ModulatedController<T>::Parameters::validate()) return problem;
    if (!(std::isfinite(bandwidth) && bandwidth > T(0)))
      return "the bandwidth of the control must be above zero";
    if (!(bandwidth * T(this->period_ns) <= T(0.5e9))) {
      return "the bandwidth of the control must be at most 0.5 divided by the control period";
    }
    return nullptr;
  }

  /// 1 − e^{−α t_period}: what of an error is gone after a period. [-]
  [[nodiscard]] T approach() const noexcept { return -std::expm1(-bandwidth * T(this->period_ns) * T(1e-9)); }
};

}  // namespace sextant
