#pragma once

#include <cstdint>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// White noise of standard normal distribution, by a counter instead of a state: sample n of a seed is
/// always the same, on every machine.
///
///   r = (s_1 + … + s_12 − 6)/4,  s of 16 bits from three outputs of SplitMix64
///   x = r (a_1 + r² (a_3 + r² (a_5 + r² (a_7 + r² a_9)))), |x| < 8.7
///
/// The polynomial gives the sum the tails of the normal distribution. It takes no function of the
/// mathematical library, whose last bits depend on the machine.
/// Source: D. Teichroew in D. E. Knuth, "The Art of Computer Programming", vol. 2, 1st ed., 3.4.1; G. Steele
/// et al., "Fast splittable pseudorandom number generators", OOPSLA 2014.
class NormalNoise {
 public:
  explicit constexpr NormalNoise(std::uint64_t seed) noexcept : key_{mixed(seed)} {}

  /// Sample n. [-]
  [[nodiscard]] constexpr double operator()(std::uint64_t n) const noexcept SEXTANT_NONBLOCKING {
    std::uint64_t sum = 0;
    for (std::uint64_t word = 3 * n; word != 3 * n + 3; ++word)
      sum += sum_of_parts(mixed(key_ + step * word));
    // The mean of the sum of twelve numbers from 0 to 65535 is 393 210; their variance is 65536² − 1.
    const double r = (double(sum) - 393'210.0) * (0.25 / 65'536.0);
    const double q = r * r;
    return r * (3.949846138 + q * (0.252408784 + q * (0.076542912 + q * (0.008355968 + q * 0.029899776))));
  }

 private:
  static constexpr std::uint64_t step = 0x9e3779b97f4a7c15U;

  /// The output function of SplitMix64.
  static constexpr std::uint64_t mixed(std::uint64_t x) noexcept SEXTANT_NONBLOCKING {
    x += step;
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
    return x ^ (x >> 31U);
  }
  static constexpr std::uint64_t sum_of_parts(std::uint64_t x) noexcept SEXTANT_NONBLOCKING {
    return (x & 0xffffU) + (x >> 16U & 0xffffU) + (x >> 32U & 0xffffU) + (x >> 48U);
  }

  std::uint64_t key_;
};

}  // namespace sextant
