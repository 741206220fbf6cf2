#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "sextant/core/description.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/power_stage/converter.hpp"

namespace sextant {

/// An encoder with two tracks of sines in quadrature, the errors of its tracks, and its converters. None by
/// default.
struct SinCosEncoderParameters {
  static constexpr int most_periods = 512;

  int periods{};              ///< N, sines a revolution; 0: an ideal sensor [-]
  double amplitude_error{};   ///< a, by which the sine's amplitude is larger than the cosine's [-]
  double quadrature_error{};  ///< ε, by which the cosine's track is ahead of its place, of a sine [rad]
  double sine_offset{};       ///< s_0, by the cosine's amplitude [-]
  double cosine_offset{};     ///< c_0, the same of the cosine [-]
  int bits{};                 ///< of the converters of both tracks; 0: not quantised [-]
  int window_periods{1};      ///< control periods over which the speed is the difference of the angle [-]

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    if (periods < 0 || periods > 100'000) return "a sin/cos encoder has 0 to 100000 sines a revolution";
    if (!(std::abs(amplitude_error) <= 0.3 && std::abs(quadrature_error) <= 0.3 &&
          std::abs(sine_offset) <= 0.3 && std::abs(cosine_offset) <= 0.3))
      return "the errors of a sin/cos encoder must be from -0.3 to 0.3";
    if (bits < 0 || bits > 24) return "a converter has 0 to 24 bits";
    return window_periods >= 1 && window_periods <= most_periods ? nullptr
                                                                 : "the speed's window has 1 to 512 periods";
  }

  /// Bound of the speed's error by quantisation alone, of tracks without errors and control periods of
  /// period_s [s]; 0 without bits. Each track is off by up to half a step, 2/2^bits, so the angle of the
  /// sines by up to E = arcsin(√2 · 2/2^bits), and the difference over the window T by twice of it:
  ///   |Δω_m| ≤ 2 E/(N T)
  /// [rad/s]
  [[nodiscard]] double quantisation_error(double period_s) const noexcept {
    if (bits == 0 || periods == 0) return 0.0;
    const double e = std::asin(std::min(1.0, std::numbers::sqrt2 * std::ldexp(2.0, -bits)));
    return 2.0 * e / (periods * window_periods * period_s);
  }
};

inline void describe(Description& d, SinCosEncoderParameters& p) {
  auto& [periods, amplitude_error, quadrature_error, sine_offset, cosine_offset, bits, window_periods] = p;
  d.integer("periods", periods, "", 0, 100'000,
            "sines of each of its two tracks a revolution; 0: speed and angle are the true ones, or those of "
            "another sensor");
  d.number("amplitude_error", amplitude_error,
           {"", -0.3, 0.3, "by which the sine's amplitude is larger than the cosine's: a second harmonic"});
  d.number("quadrature_error_rad", quadrature_error,
           {"rad", -0.3, 0.3,
            "by which the cosine's track is ahead of its place, of a sine: a second harmonic and a mean"});
  d.number("sine_offset", sine_offset,
           {"", -0.3, 0.3, "offset of the sine, by the cosine's amplitude: a first harmonic"});
  d.number("cosine_offset", cosine_offset, {"", -0.3, 0.3, "the same of the cosine"});
  d.integer("bits", bits, "", 0, 24,
            "resolution of the converters of both tracks, over both signs of twice the amplitude; 0: not "
            "quantised");
  d.integer("window_periods", window_periods, "", 1, SinCosEncoderParameters::most_periods,
            "control periods over which the speed is the difference of the angle: more make a finer, later "
            "speed");
}

/// Position and speed by the arctangent of an encoder's two tracks and the count of their sines. At θ =
/// N theta_m the tracks are
///   s = (1 + a) sin θ + s_0,   c = cos(θ − ε) + c_0
/// and angle and speed, with the turns n of the vector (c, s), of which the counter of the drive loses none,
///   N theta = atan2(s, c) + 2π n,   omega = (theta(t) − theta(t − T))/T
/// N theta is wrong by (a/2) sin 2θ + (ε/2)(cos 2θ − 1) + s_0 cos θ − c_0 sin θ to first order. An error
/// δ sin kθ of it makes one of k δ omega_m cos kθ · sinc(k N omega_m T/2) in the speed, half of the window
/// late. Source: S. Kuntz et al., "Harmonic analysis of the arctangent function regarding the angular error
/// introduced by superimposed Fourier series for application in sine/cosine angle encoders",
/// arXiv:2205.08472, 2022.
class SinCosEncoder {
 public:
  SinCosEncoder() noexcept = default;
  /// The parameters must be valid.
  explicit SinCosEncoder(const SinCosEncoderParameters& p) noexcept
      : parameters_{p}, converter_{{.range = p.bits > 0 ? 2.0 : 0.0, .bits = p.bits}, true} {}

  [[nodiscard]] bool is_ideal() const noexcept SEXTANT_NONBLOCKING { return parameters_.periods == 0; }
  /// Measured angle, not wrapped. [rad]
  [[nodiscard]] double theta() const noexcept SEXTANT_NONBLOCKING { return now_.theta; }
  /// Measured speed. [rad/s]
  [[nodiscard]] double omega() const noexcept SEXTANT_NONBLOCKING { return omega_; }

  /// The past of a shaft that has long been turning with omega_m [rad/s] and is at theta_m [rad] at t_ns
  /// [ns], in samples period_ns [ns] apart. To be called before the first `step`, which is that at t_ns.
  void begin(double theta_m, double omega_m, std::int64_t t_ns,
             std::int64_t period_ns) noexcept SEXTANT_NONBLOCKING {
    for (std::int64_t ns = parameters_.window_periods * period_ns; ns > 0; ns -= period_ns)
      step(theta_m - omega_m * (double(ns) * 1e-9), t_ns - ns);
  }

  /// The shaft is at theta_m [rad], not wrapped and finite, at t_ns [ns].
  void step(double theta_m, std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    now_ = {t_ns, angle(parameters_.periods * theta_m) / parameters_.periods};
    if (known_ > 0) {
      const Sample& then = samples_[(newest_ + samples_.size() + 1 - known_) % samples_.size()];
      if (t_ns > then.t_ns) omega_ = (now_.theta - then.theta) / (double(t_ns - then.t_ns) * 1e-9);
    }
    newest_ = (newest_ + 1) % samples_.size();
    samples_[newest_] = now_;
    known_ = std::min(known_ + 1, std::size_t(parameters_.window_periods));
  }

 private:
  struct Sample {
    std::int64_t t_ns{};
    double theta{};  ///< as measured [rad]
  };

  /// Angle that the tracks show of the sines' angle, with its turns: off by less than half a turn. [rad]
  [[nodiscard]] double angle(double theta) const noexcept SEXTANT_NONBLOCKING {
    const double s =
        converter_((1.0 + parameters_.amplitude_error) * std::sin(theta) + parameters_.sine_offset, 0.0);
    const double c =
        converter_(std::cos(theta - parameters_.quadrature_error) + parameters_.cosine_offset, 0.0);
    return theta + std::remainder(std::atan2(s, c) - theta, 2.0 * std::numbers::pi);
  }

  SinCosEncoderParameters parameters_{};
  Converter converter_{};
  std::array<Sample, std::size_t(SinCosEncoderParameters::most_periods)> samples_{};  ///< a ring
  std::size_t newest_{};
  std::size_t known_{};  ///< samples of the ring that count
  Sample now_{};
  double omega_{};  ///< [rad/s]
};

}  // namespace sextant
