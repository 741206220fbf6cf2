#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// The pairs of a Foster network as a data sheet has them: (thermal resistance [K/W], time constant [s]).
using FosterPairs = std::vector<std::pair<double, double>>;

/// Rise of a temperature by a transient thermal impedance, the sum of a few exponentials:
///   Z(t) = Σ_k R_k (1 − e^(−t/τ_k)),   τ_k dx_k/dt = R_k P − x_k,   rise = Σ_k x_k
/// Over a step the power is constant, and the rise moves without any error of discretisation:
///   x_k(t + h) = e^(−h/τ_k) x_k(t) + (1 − e^(−h/τ_k)) R_k P
/// The pairs are a fit and no places: a network is one of junction to case, or of case to ambient. Source:
/// that of `InverterLosses`.
class FosterNetwork {
 public:
  static constexpr std::size_t most_pairs = 4;

  FosterNetwork() noexcept = default;
  /// Pairs that `validate_pairs` takes.
  explicit FosterNetwork(const FosterPairs& pairs) noexcept : count_{pairs.size()} {
    for (std::size_t k = 0; k < count_; ++k) {
      resistance_[k] = pairs[k].first;
      time_constant_[k] = pairs[k].second;
    }
  }

  /// Sets the rise [K], in the shares that a constant power leads to.
  void begin(double rise) noexcept SEXTANT_NONBLOCKING {
    double sum = 0.0;
    for (const double r : resistance_) sum += r;
    for (std::size_t k = 0; k < count_; ++k) x_[k] = rise * resistance_[k] / sum;
  }

  /// Over h [s] of that power [W].
  void step(double power, double h) noexcept SEXTANT_NONBLOCKING {
    if (h != step_) note_step(h);
    for (std::size_t k = 0; k < count_; ++k) x_[k] += share_[k] * (resistance_[k] * power - x_[k]);
  }

  /// [K]
  [[nodiscard]] double rise() const noexcept SEXTANT_NONBLOCKING {
    double sum = 0.0;
    for (const double x : x_) sum += x;
    return sum;
  }

 private:
  void note_step(double h) noexcept SEXTANT_NONBLOCKING {
    step_ = h;
    for (std::size_t k = 0; k < count_; ++k) share_[k] = -std::expm1(-h / time_constant_[k]);
  }

  std::size_t count_{0};
  double step_{0.0};                                ///< for which the shares are [s]
  std::array<double, most_pairs> resistance_{};     ///< [K/W]
  std::array<double, most_pairs> time_constant_{};  ///< [s]
  std::array<double, most_pairs> share_{};          ///< 1 − e^(−h/τ) [-]
  std::array<double, most_pairs> x_{};              ///< [K]
};

/// nullptr when the pairs make a network, else what is wrong. No pairs are none: the rise is zero.
[[nodiscard]] inline const char* validate_pairs(const FosterPairs& pairs) noexcept {
  if (pairs.size() > FosterNetwork::most_pairs) return "a Foster network has at most four pairs";
  for (const auto& [resistance, time_constant] : pairs) {
    if (!(std::isfinite(resistance) && resistance > 0.0 && std::isfinite(time_constant) &&
          time_constant > 0.0))
      return "resistances and time constants of a Foster network must be finite and above zero";
  }
  return nullptr;
}

}  // namespace sextant
