#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "sextant/core/description.hpp"
#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// How an encoder's speed is made from its edges.
enum class EncoderSpeed : std::uint8_t {
  count,  ///< edges in the window, by the window's duration
  period  ///< edges in the window, by the time between the last edge of it and the last one before it
};

/// An incremental encoder with two tracks in quadrature, all edges of which are counted.
struct EncoderParameters {
  static constexpr int most_periods = 512;

  int lines{};  ///< N a revolution; 0: an ideal sensor [-]
  EncoderSpeed speed{EncoderSpeed::count};
  int window_periods{40};  ///< control periods of the window [-]

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    if (lines < 0) return "an encoder cannot have fewer than no lines";
    return window_periods >= 1 && window_periods <= most_periods ? nullptr
                                                                 : "the speed's window has 1 to 512 periods";
  }
};

inline void describe(Description& d, EncoderParameters& p) {
  auto& [lines, speed, window_periods] = p;
  d.integer("lines", lines, "", 0, 1'000'000,
            "lines of the encoder a revolution, with four edges each; 0: speed and angle are the true ones");
  d.choice("speed", speed, {{"count", EncoderSpeed::count}, {"period", EncoderSpeed::period}},
           "how the speed is made: edges in the window by its duration, or by the time from the last edge "
           "before the window to the last one in it");
  d.integer("window_periods", window_periods, "", 1, EncoderParameters::most_periods,
            "control periods over which edges are counted or timed: more make a finer, later speed");
}

/// Position and speed from the edges of an encoder, Δ = 2π/4N apart:
///   theta = Δ floor(theta_m/Δ)
///   count:   omega = Δ (n(t) − n(t − T))/T, which has a resolution of Δ/T
///   period:  omega = Δ (e(t) − e(t − T))/(t_e(t) − t_e(t − T)), with e the place and t_e the instant of the
///            last edge; without an edge in the window the speed before, but at most Δ/(t − t_e) of it
/// The window T ends with the sample and begins with one before. The instant of an edge, of which only the
/// last between two samples counts, is that at which the straight line between the angles of both samples
/// crosses it, to 1 ns. Before there are two edges the speed is zero; `begin` gives a shaft that has been
/// turning those of its past. Source: T. Ohmae et al., "A microprocessor-controlled high-accuracy wide-range
/// speed regulator for motor drives", IEEE Trans. Ind. Electron. 29(3), 1982.
class Encoder {
 public:
  Encoder() noexcept = default;
  /// The parameters must be valid.
  explicit Encoder(const EncoderParameters& p) noexcept
      : method_{p.speed}, window_{std::size_t(p.window_periods)} {
    if (p.lines > 0) edge_angle_ = 2.0 * std::numbers::pi / (4.0 * p.lines);
  }

  [[nodiscard]] bool is_ideal() const noexcept SEXTANT_NONBLOCKING { return edge_angle_ == 0.0; }
  /// Measured angle since the start, not wrapped. [rad]
  [[nodiscard]] double theta() const noexcept SEXTANT_NONBLOCKING { return edge_angle_ * double(now_.count); }
  /// Measured speed. [rad/s]
  [[nodiscard]] double omega() const noexcept SEXTANT_NONBLOCKING { return omega_; }

  /// The past of a shaft that has long been turning with omega_m [rad/s] and is at theta_m [rad] at t_ns
  /// [ns], in samples period_ns [ns] apart. To be called before the first `step`, which is that at t_ns.
  void begin(double theta_m, double omega_m, std::int64_t t_ns,
             std::int64_t period_ns) noexcept SEXTANT_NONBLOCKING {
    const auto step_back = [&](std::int64_t ns) { step(theta_m - omega_m * (double(ns) * 1e-9), t_ns - ns); };
    const std::int64_t window_ns = std::int64_t(window_) * period_ns;
    constexpr double longest_s = 10.0;  // of less than an edge in it, the speed is none
    const double between_s = std::min(edge_angle_ / std::abs(omega_m), longest_s);
    // An edge before the window, whose instant begins the window of edges, and one more before it.
    step_back(window_ns + std::int64_t(3e9 * between_s));
    step_back(window_ns + std::int64_t(1.5e9 * between_s));
    for (std::int64_t ns = window_ns; ns > 0; ns -= period_ns) step_back(ns);
  }

  /// The shaft is at theta_m [rad], not wrapped and finite, at t_ns [ns].
  void step(double theta_m, std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    Sample next{t_ns, std::int64_t(std::floor(theta_m / edge_angle_)), now_.edge, now_.edge_ns};
    if (known_ > 0 && next.count != now_.count) {
      next.edge = next.count > now_.count ? next.count : next.count + 1;
      const double share = (edge_angle_ * double(next.edge) - theta_m_) / (theta_m - theta_m_);
      next.edge_ns = now_.t_ns + std::int64_t(share * double(t_ns - now_.t_ns));
      // No edge before: the window of edges begins here.
      if (!has_edge_ && method_ == EncoderSpeed::period) known_ = 0;
      has_edge_ = true;
    }
    theta_m_ = theta_m;
    now_ = next;
    update_speed();
    samples_[place(0)] = next;
    newest_ = place(0);
    known_ = std::min(known_ + 1, window_);
  }

 private:
  struct Sample {
    std::int64_t t_ns{};
    std::int64_t count{};    ///< edges below the angle
    std::int64_t edge{};     ///< place of the last edge, in edges
    std::int64_t edge_ns{};  ///< its instant
  };

  /// Where the sample `ago` samples before the next one is kept.
  [[nodiscard]] std::size_t place(std::size_t ago) const noexcept SEXTANT_NONBLOCKING {
    return (newest_ + 1 + samples_.size() - ago) % samples_.size();
  }

  void update_speed() noexcept SEXTANT_NONBLOCKING {
    if (known_ == 0) return;
    const Sample& then = samples_[place(known_)];
    if (method_ == EncoderSpeed::count) {
      if (now_.t_ns > then.t_ns) omega_ = rate(now_.count - then.count, now_.t_ns - then.t_ns);
    } else if (has_edge_ && now_.edge_ns > then.edge_ns) {
      omega_ = rate(now_.edge - then.edge, now_.edge_ns - then.edge_ns);
    } else if (has_edge_ && now_.t_ns > now_.edge_ns) {
      const double most = rate(1, now_.t_ns - now_.edge_ns);
      omega_ = std::clamp(omega_, -most, most);
    }
  }
  [[nodiscard]] double rate(std::int64_t edges, std::int64_t duration_ns) const noexcept SEXTANT_NONBLOCKING {
    return edge_angle_ * double(edges) / (double(duration_ns) * 1e-9);
  }

  double edge_angle_{};  ///< Δ; 0: ideal [rad]
  EncoderSpeed method_{EncoderSpeed::count};
  std::size_t window_{1};
  std::array<Sample, std::size_t(EncoderParameters::most_periods)> samples_{};  ///< a ring
  std::size_t newest_{};
  std::size_t known_{};  ///< samples of the ring that count
  Sample now_{};
  double theta_m_{};  ///< of the last sample [rad]
  double omega_{};    ///< [rad/s]
  bool has_edge_{false};
};

}  // namespace sextant
