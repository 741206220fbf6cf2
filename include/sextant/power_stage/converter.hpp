#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// A transducer with its analog-to-digital converter. Ideal by default; each value acts by itself.
struct ConverterParameters {
  double gain_error{};  ///< g [-]
  double offset{};      ///< o, in the unit of the quantity
  double noise{};       ///< σ, standard deviation, in the unit of the quantity
  double range{};       ///< R, full scale, in the unit of the quantity; 0: not limited
  int bits{};           ///< N of the converter over its range; 0: not quantised [-]

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    if (!(std::isfinite(gain_error) && gain_error > -1.0)) return "the gain error must be above -1";
    if (!std::isfinite(offset)) return "the offset must be finite";
    if (!(std::isfinite(noise) && noise >= 0.0)) return "the noise must be finite and not below zero";
    if (!(std::isfinite(range) && range >= 0.0)) return "the range must be finite and not below zero";
    if (bits < 0 || bits > 24) return "a converter has 0 to 24 bits";
    return bits > 0 && range == 0.0 ? "a converter with bits needs a range" : nullptr;
  }
};

/// y = q((1 + g) x + o + σ n), with q rounding to the nearest of 2^N steps over the range and saturating at
/// its ends. A bipolar range is [−R, R), a unipolar one [0, R), without bits its upper end included.
class Converter {
 public:
  /// The converter of an ideal sensor.
  constexpr Converter() noexcept = default;

  /// The parameters must be valid.
  Converter(const ConverterParameters& p, bool is_bipolar) noexcept
      : gain_{1.0 + p.gain_error}, offset_{p.offset}, noise_{p.noise}, is_limited_{p.range > 0.0} {
    const double span = is_bipolar ? 2.0 * p.range : p.range;
    step_ = p.bits > 0 ? std::ldexp(span, -p.bits) : 0.0;
    low_ = is_bipolar ? -p.range : 0.0;
    high_ = p.range - step_;
    is_ideal_ = p.gain_error == 0.0 && p.offset == 0.0 && p.noise == 0.0 && !is_limited_;
  }

  [[nodiscard]] bool is_ideal() const noexcept SEXTANT_NONBLOCKING { return is_ideal_; }

  /// Largest reading there can be; infinite without a range. [unit of the quantity]
  [[nodiscard]] double highest() const noexcept SEXTANT_NONBLOCKING {
    return is_limited_ ? high_ : std::numeric_limits<double>::infinity();
  }

  /// What is read of x with a standard normal sample n; NaN of NaN.
  [[nodiscard]] double operator()(double x, double n) const noexcept SEXTANT_NONBLOCKING {
    if (is_ideal_) return x;
    double y = gain_ * x + offset_ + noise_ * n;
    if (!is_limited_) return y;
    if (step_ > 0.0) y = step_ * std::floor(y / step_ + 0.5);
    return std::clamp(y, low_, high_);
  }

 private:
  double gain_{1.0};
  double offset_{};
  double noise_{};
  double step_{};  ///< of the quantisation; 0: none
  double low_{};   ///< of what can be read
  double high_{};  ///< of what can be read
  bool is_limited_{false};
  bool is_ideal_{true};
};

}  // namespace sextant
