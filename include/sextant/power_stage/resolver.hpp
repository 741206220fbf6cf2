#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "sextant/core/description.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/power_stage/converter.hpp"

namespace sextant {

/// A resolver with the errors of its windings and its tracking converter. None by default.
struct ResolverParameters {
  int pole_pairs{};           ///< P, periods of its signals a revolution; 0: an ideal sensor [-]
  double amplitude_error{};   ///< a, by which the sine's amplitude is larger than the cosine's [-]
  double quadrature_error{};  ///< ε, by which the cosine winding is ahead of its place, electrical [rad]
  double sine_offset{};       ///< of the demodulated sine, by the cosine's amplitude [-]
  double cosine_offset{};     ///< the same of the cosine [-]
  int bits{};                 ///< of the converters of both signals; 0: not quantised [-]
  double bandwidth{300};      ///< natural frequency of the tracking loop [Hz]

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    if (pole_pairs < 0 || pole_pairs > 64) return "a resolver has 0 to 64 pole pairs";
    if (!(std::abs(amplitude_error) <= 0.5 && std::abs(quadrature_error) <= 0.5 &&
          std::abs(sine_offset) <= 0.5 && std::abs(cosine_offset) <= 0.5))
      return "the errors of a resolver must be from -0.5 to 0.5";
    if (bits < 0 || bits > 24) return "a converter has 0 to 24 bits";
    return std::isfinite(bandwidth) && bandwidth > 0.0 ? nullptr
                                                       : "the bandwidth of a resolver must be above zero";
  }

  /// Bound of the speed's error by quantisation alone, of windings without errors; 0 without bits. Each
  /// signal is off by up to half a step, 2/2^N, so the loop's e by up to E = √2 · 2/2^N. To first order its
  /// speed is off by W(s) e with W = ω_n² s/(s² + 2ζω_n s + ω_n²), and the largest response to any |e| ≤ E
  /// is E ∫|w| dt, of ζ = 1/√2
  ///   P |Δω_m| ≤ E ω_n 2 e^(−π/4)/(1 − e^(−π)) = 0.953 E ω_n
  /// [rad/s]
  [[nodiscard]] double quantisation_error() const noexcept {
    if (bits == 0 || pole_pairs == 0) return 0.0;
    constexpr double pi = std::numbers::pi;
    const double e = std::numbers::sqrt2 * std::ldexp(2.0, -bits);
    return e * 2.0 * pi * bandwidth * 2.0 * std::exp(-pi / 4.0) / (1.0 - std::exp(-pi)) / pole_pairs;
  }
};

inline void describe(Description& d, ResolverParameters& p) {
  auto& [pole_pairs, amplitude_error, quadrature_error, sine_offset, cosine_offset, bits, bandwidth] = p;
  d.integer(
      "pole_pairs", pole_pairs, "", 0, 64,
      "periods of the resolver's signals a revolution; 0: speed and angle are the true ones, or those of "
      "another sensor");
  d.number("amplitude_error", amplitude_error,
           {"", -0.5, 0.5, "by which the sine's amplitude is larger than the cosine's: a second harmonic"});
  d.number("quadrature_error_rad", quadrature_error,
           {"rad", -0.5, 0.5,
            "by which the cosine winding is ahead of its place, electrical: a second harmonic and a mean"});
  d.number("sine_offset", sine_offset,
           {"", -0.5, 0.5, "offset of the sine, by the cosine's amplitude: a first harmonic"});
  d.number("cosine_offset", cosine_offset, {"", -0.5, 0.5, "the same of the cosine"});
  d.integer("bits", bits, "", 0, 24,
            "resolution of the converters of sine and cosine, over both signs of twice the amplitude; 0: not "
            "quantised");
  d.number("bandwidth_hz", bandwidth,
           {"Hz", 1, 1e4, "natural frequency of the tracking loop that makes angle and speed, damping 0.71"});
}

/// Position and speed by the tracking converter of a resolver. Its signals at θ = P theta_m, demodulated
/// without error of the carrier:
///   s = (1 + a) sin θ + s_0,   c = cos(θ − ε) + c_0
/// The converter turns φ and its speed ω after them by a loop of second order and type II, without error at
/// constant speed:
///   e = (s cos φ − c sin φ)/√(s² + c²),   dφ/dt = ω + 2ζω_n e,   dω/dt = ω_n² e,   ζ = 1/√2
/// Its angle is wrong by (a/2) sin 2θ + (ε/2)(cos 2θ − 1) + s_0 cos θ − c_0 sin θ to first order, filtered by
/// the loop. Between two samples the shaft turns evenly. Source: D. C. Hanselman, "Resolver signal
/// requirements for high accuracy resolver-to-digital conversion", IEEE Trans. Ind. Electron. 37(6), 1990.
class Resolver {
 public:
  Resolver() noexcept = default;
  /// The parameters must be valid.
  explicit Resolver(const ResolverParameters& p) noexcept
      : parameters_{p},
        rate_{2.0 * std::numbers::pi * p.bandwidth},
        converter_{{.range = p.bits > 0 ? 2.0 : 0.0, .bits = p.bits}, true} {}

  [[nodiscard]] bool is_ideal() const noexcept SEXTANT_NONBLOCKING { return parameters_.pole_pairs == 0; }
  /// Measured angle, not wrapped. [rad]
  [[nodiscard]] double theta() const noexcept SEXTANT_NONBLOCKING {
    return loop_.phi / parameters_.pole_pairs;
  }
  /// Measured speed. [rad/s]
  [[nodiscard]] double omega() const noexcept SEXTANT_NONBLOCKING {
    return loop_.omega / parameters_.pole_pairs;
  }

  /// The loop has locked on the shaft, which is at theta_m [rad] with omega_m [rad/s] at t_ns [ns].
  void begin(double theta_m, double omega_m, std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    loop_ = {parameters_.pole_pairs * theta_m, parameters_.pole_pairs * omega_m};
    theta_ = loop_.phi;
    t_ns_ = t_ns;
  }

  /// The shaft has come to theta_m [rad], not wrapped and finite, at t_ns [ns].
  void step(double theta_m, std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    const double seconds = double(t_ns - t_ns_) * 1e-9;
    const double from = theta_;
    theta_ = parameters_.pole_pairs * theta_m;
    t_ns_ = t_ns;
    if (!(seconds > 0.0)) return;
    constexpr double most = 1000.0;
    const double turn = std::abs(theta_ - from) + rate_ * seconds;
    const int steps = int(std::clamp(std::ceil(turn / longest_step), 1.0, most));
    const double h = seconds / steps;
    for (int k = 0; k < steps; ++k)
      move(from + (theta_ - from) * k / steps, from + (theta_ - from) * (k + 1) / steps, h);
  }

 private:
  static constexpr double longest_step = 0.2;  ///< of the signals' and the loop's angle together [rad]

  struct Loop {
    double phi{};    ///< [rad]
    double omega{};  ///< [rad/s]
  };

  /// (dφ/dt, dω/dt) with the signals at an angle.
  [[nodiscard]] Loop slope(double theta, const Loop& x) const noexcept SEXTANT_NONBLOCKING {
    const double s =
        converter_((1.0 + parameters_.amplitude_error) * std::sin(theta) + parameters_.sine_offset, 0.0);
    const double c =
        converter_(std::cos(theta - parameters_.quadrature_error) + parameters_.cosine_offset, 0.0);
    const double amplitude = std::hypot(s, c);
    const double e = amplitude > 0.0 ? (s * std::cos(x.phi) - c * std::sin(x.phi)) / amplitude : 0.0;
    return {x.omega + std::numbers::sqrt2 * rate_ * e, rate_ * rate_ * e};
  }
  /// Runge-Kutta of order 4.
  void move(double from, double to, double h) noexcept SEXTANT_NONBLOCKING {
    const auto ahead = [this](const Loop& k, double by) -> Loop {
      return {loop_.phi + by * k.phi, loop_.omega + by * k.omega};
    };
    const double middle = 0.5 * (from + to);
    const Loop a = slope(from, loop_);
    const Loop b = slope(middle, ahead(a, 0.5 * h));
    const Loop c = slope(middle, ahead(b, 0.5 * h));
    const Loop d = slope(to, ahead(c, h));
    loop_.phi += h / 6.0 * (a.phi + 2.0 * (b.phi + c.phi) + d.phi);
    loop_.omega += h / 6.0 * (a.omega + 2.0 * (b.omega + c.omega) + d.omega);
  }

  ResolverParameters parameters_{};
  double rate_{};  ///< ω_n [rad/s]
  Converter converter_{};
  Loop loop_{};
  double theta_{};       ///< P theta_m of the last sample [rad]
  std::int64_t t_ns_{};  ///< its instant [ns]
};

}  // namespace sextant
