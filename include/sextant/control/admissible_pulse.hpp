#pragma once

#include <algorithm>
#include <cstdint>

namespace sextant {

/// For how long a leg may be high in a control period: not at all, throughout, or for a time of which neither
/// the high nor the low part is too short.
struct AdmissiblePulse {
  std::int32_t shortest_high_ns{0};  ///< [ns]
  std::int32_t shortest_low_ns{0};   ///< of the low parts together [ns]

  /// In a period that begins and ends low, where each part is to last for the inverter's minimum pulse t_min:
  /// then so does every pulse, whatever the periods before and after are. The halves of the low part are sums
  /// of up to three halves of segments, each rounded to whole nanoseconds.
  [[nodiscard]] static constexpr AdmissiblePulse symmetric(std::int32_t minimum_ns) noexcept {
    constexpr std::int32_t rounding_ns = 3;
    return {minimum_ns, minimum_ns > 0 ? 2 * minimum_ns + rounding_ns : 0};
  }
  /// The same in a period with one edge.
  [[nodiscard]] static constexpr AdmissiblePulse one_edge(std::int32_t minimum_ns) noexcept {
    return {minimum_ns, minimum_ns};
  }

  [[nodiscard]] constexpr bool acts() const noexcept { return shortest_high_ns > 0 || shortest_low_ns > 0; }

  /// The nearest such time to a given one within the period. [ns]
  [[nodiscard]] constexpr std::int32_t nearest(std::int32_t high_ns, std::int32_t period_ns) const noexcept {
    const std::int32_t shortest = std::min(shortest_high_ns, period_ns / 2);
    const std::int32_t longest = period_ns - std::min(shortest_low_ns, period_ns / 2);
    if (high_ns < shortest) return 2 * high_ns < shortest ? 0 : shortest;
    if (high_ns > longest) return 2 * high_ns > longest + period_ns ? period_ns : longest;
    return high_ns;
  }
};

}  // namespace sextant
