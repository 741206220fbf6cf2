#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "sextant/core/description.hpp"
#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// A sensor of a temperature with its converter. Ideal by default; each value acts by itself.
struct TemperatureSensorParameters {
  double gain_error{};              ///< g, of the temperature in °C [-]
  double offset{};                  ///< o [K]
  double noise{};                   ///< σ, standard deviation [K]
  double step{};                    ///< of the converter; 0: not quantised [K]
  std::int64_t time_constant_ns{};  ///< τ, by which the sensor follows; 0: at once [ns]

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    if (!(std::isfinite(gain_error) && gain_error > -1.0))
      return "the gain error of the temperature sensor must be above -1";
    if (!std::isfinite(offset)) return "the offset of the temperature sensor must be finite";
    for (const double x : {noise, step}) {
      if (!(std::isfinite(x) && x >= 0.0))
        return "noise and step of the temperature sensor must be finite and not below zero";
    }
    return time_constant_ns >= 0 ? nullptr
                                 : "the time constant of the temperature sensor must not be below zero";
  }
};

inline void describe(Description& d, TemperatureSensorParameters& p) {
  auto& [gain_error, offset, noise, step, time_constant_ns] = p;
  d.number("gain_error", gain_error, {"", -0.99, 10, "relative error of the gain, of the temperature in C"});
  d.number("offset_k", offset, {"K", -500, 500, "offset of the reading"});
  d.number("noise_k", noise, {"K", 0, 500, "standard deviation of the white, normal noise of each reading"});
  d.number("step_k", step, {"K", 0, 100, "resolution of the converter; 0: not quantised"});
  d.time("time_constant_ms", time_constant_ns,
         in_ms(0, 1e7, "by which the sensor follows the temperature, of first order; 0: at once"));
}

/// y = q((1 + g) x + o + σ n), q rounding to the nearest whole number of steps, τ dx/dt = T − x. x is exact
/// for a temperature that is held from reading to reading; it begins with the first one. [°C]
class TemperatureSensor {
 public:
  /// The parameters must be valid.
  explicit TemperatureSensor(const TemperatureSensorParameters& p) noexcept : p_{p} {}

  /// True where each reading is the temperature.
  [[nodiscard]] bool is_ideal() const noexcept SEXTANT_NONBLOCKING {
    return p_.gain_error == 0.0 && p_.offset == 0.0 && p_.noise == 0.0 && p_.step == 0.0 &&
           p_.time_constant_ns == 0;
  }
  [[nodiscard]] bool is_noisy() const noexcept SEXTANT_NONBLOCKING { return p_.noise > 0.0; }

  /// What is read of a temperature at t_ns, which must not fall, with a standard normal sample n. [°C]
  [[nodiscard]] double step(double temperature, std::int64_t t_ns, double n) noexcept SEXTANT_NONBLOCKING {
    const double y = (1.0 + p_.gain_error) * followed(temperature, t_ns) + p_.offset + p_.noise * n;
    return p_.step > 0.0 ? p_.step * std::floor(y / p_.step + 0.5) : y;
  }

 private:
  /// x at t_ns. [°C]
  [[nodiscard]] double followed(double temperature, std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    double x = temperature;
    if (followed_ && p_.time_constant_ns != 0) {
      const double left = std::exp(-double(t_ns - last_ns_) / double(p_.time_constant_ns));
      x += (*followed_ - temperature) * left;
    }
    followed_ = x;
    last_ns_ = t_ns;
    return x;
  }

  TemperatureSensorParameters p_;
  std::optional<double> followed_{};  ///< x [°C]
  std::int64_t last_ns_{};            ///< of the last reading [ns]
};

}  // namespace sextant
