#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "sextant/control/towards.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// A direct current with a sine above it, whose frequency rises in equal ratios from tone to tone:
///   i = I_0 + A sin(2π n/N_m),   N_m = N_0 (N_M/N_0)^(m/M),   m = 0 … M
/// with n the control periods since the tone began and N_m those of its cycle, rounded to a whole number.
/// With A below I_0 the current keeps its sign. The current rises to I_0 by a ramp and settles; each tone
/// settles for whole cycles and is then measured in blocks of whole cycles, over which I_0 and sine are
/// orthogonal. It ends at zero.
template <class T = double>
class ToneSequence {
 public:
  struct Parameters {
    T bias{T(1)};                     ///< I_0 [A]
    T amplitude{T(0.5)};              ///< A [A]
    T slope{T(0.1)};                  ///< of the ramps, by the period [A]
    int tones{4};                     ///< M + 1, 2 at least [-]
    int blocks{4};                    ///< of each tone [-]
    std::int32_t longest_cycle{100};  ///< N_0, in control periods [-]
    std::int32_t shortest_cycle{10};  ///< N_M, the same [-]
    std::int32_t settle_periods{1};   ///< of I_0, and of a tone at least [-]
    std::int32_t hold_periods{1};     ///< of a block at least [-]
  };

  explicit ToneSequence(const Parameters& parameters) noexcept
      : parameters_{parameters}, cycle_{parameters.longest_cycle} {}

  /// The current in the coming period. [A]
  T step() noexcept {
    if (is_done()) return reference_ = ramped(T(0));
    if (!sounds_) return approach();
    advance();
    if (is_done()) return reference_ = ramped(T(0));
    return reference_ = parameters_.bias + parameters_.amplitude * phase().beta;
  }

  /// The coming period belongs to a block.
  [[nodiscard]] constexpr bool holds() const noexcept {
    return sounds_ && !is_done() && cycles_ >= settle_cycles();
  }
  /// It is the last one of a block.
  [[nodiscard]] constexpr bool ends_level() const noexcept {
    return holds() && sample_ == cycle_ - 1 && (cycles_ + 1 - settle_cycles()) % block_cycles() == 0;
  }
  /// Blocks that are over. [-]
  [[nodiscard]] constexpr int index() const noexcept {
    const bool in_blocks = holds();
    return tone_ * parameters_.blocks + (in_blocks ? (cycles_ - settle_cycles()) / block_cycles() : 0);
  }
  [[nodiscard]] constexpr bool is_done() const noexcept { return tone_ >= parameters_.tones; }
  /// N_m, in control periods. [-]
  [[nodiscard]] constexpr std::int32_t cycle() const noexcept { return cycle_; }
  /// (cos, sin) of 2π n/N_m in the coming period. [-]
  [[nodiscard]] SpaceVector<T> phase() const noexcept {
    const T angle = T(2 * std::numbers::pi) * (T(sample_) / T(cycle_));
    return {std::cos(angle), std::sin(angle)};
  }
  void reset() noexcept {
    tone_ = 0;
    cycle_ = parameters_.longest_cycle;
    sample_ = 0;
    cycles_ = 0;
    elapsed_ = 0;
    sounds_ = false;
    reference_ = T(0);
  }

 private:
  [[nodiscard]] constexpr T ramped(T level) const noexcept {
    return towards(level, reference_, parameters_.slope);
  }
  /// To I_0, until it has settled.
  T approach() noexcept {
    if (reference_ != parameters_.bias) return reference_ = ramped(parameters_.bias);
    if (++elapsed_ >= parameters_.settle_periods) {
      sounds_ = true;
      sample_ = -1;
    }
    return reference_;
  }
  void advance() noexcept {
    if (++sample_ < cycle_) return;
    sample_ = 0;
    if (++cycles_ < settle_cycles() + parameters_.blocks * block_cycles()) return;
    cycles_ = 0;
    ++tone_;
    const T share = T(tone_) / T(parameters_.tones - 1);
    const T ratio = T(parameters_.shortest_cycle) / T(parameters_.longest_cycle);
    cycle_ = std::int32_t(std::lround(T(parameters_.longest_cycle) * std::pow(ratio, share)));
  }
  [[nodiscard]] constexpr std::int32_t settle_cycles() const noexcept {
    return whole_cycles(parameters_.settle_periods);
  }
  [[nodiscard]] constexpr std::int32_t block_cycles() const noexcept {
    return whole_cycles(parameters_.hold_periods);
  }
  [[nodiscard]] constexpr std::int32_t whole_cycles(std::int32_t periods) const noexcept {
    return (periods - 1) / cycle_ + 1;
  }

  Parameters parameters_;
  int tone_{0};              ///< m [-]
  std::int32_t cycle_;       ///< N_m [-]
  std::int32_t sample_{0};   ///< of the cycle [-]
  std::int32_t cycles_{0};   ///< of the tone that are over [-]
  std::int32_t elapsed_{0};  ///< periods at I_0 before the first tone [-]
  bool sounds_{false};       ///< I_0 has settled
  T reference_{};            ///< [A]
};

}  // namespace sextant
