#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "sextant/control/admissible_pulse.hpp"

namespace sextant {

/// Times for which the legs are high in a period, by falling voltage. [ns]
using HighTimes = std::array<std::int32_t, 3>;

/// A time [ns] to the nearest nanosecond, within [0, most]; 0 for no number.
template <class T>
[[nodiscard]] std::int32_t nearest_ns(T ns, std::int32_t most) noexcept {
  return ns > T(0) ? std::int32_t(std::min(ns + T(0.5), T(most))) : 0;
}

/// The times for which the legs can be high, for those that are wanted. Where pulses would be too short both
/// zero vectors exchange some of their time, which moves the high times of all legs alike and leaves the
/// voltage as it is: as little as suffices, up to a leg that rests; where nothing suffices, by what leaves
/// the smallest error of the voltage between two legs, each at the nearest time for which it can be high.
template <class T = double>
class PulseTimes {
 public:
  constexpr explicit PulseTimes(const AdmissiblePulse& admissible) noexcept : admissible_{admissible} {}

  /// What the legs are to be high for, by falling voltage.
  struct Wanted {
    HighTimes ideal_ns;          ///< without correction
    std::array<T, 3> longer_ns;  ///< where the leg switches [ns]
    std::int32_t period_ns;
    [[nodiscard]] constexpr bool rests(std::int32_t high_ns) const noexcept {
      return high_ns == 0 || high_ns == period_ns;
    }
  };

  /// The nearest times that are admissible.
  [[nodiscard]] HighTimes nearest(const Wanted& wanted) const noexcept {
    return admissible_.acts() ? best(wanted) : realised(wanted, 0);
  }

 private:
  /// Each leg at its nearest admissible time, where all are high longer by `shift_ns`; a leg that then rests
  /// stays as it is.
  [[nodiscard]] HighTimes realised(const Wanted& wanted, std::int32_t shift_ns) const noexcept {
    HighTimes high_ns{};
    for (std::size_t n = 0; n < 3; ++n) {
      const std::int32_t ideal_ns = wanted.ideal_ns[n] + shift_ns;
      high_ns[n] = wanted.rests(ideal_ns)
                       ? ideal_ns
                       : admissible_.nearest(nearest_ns(T(ideal_ns) + wanted.longer_ns[n], wanted.period_ns),
                                             wanted.period_ns);
    }
    return high_ns;
  }

  /// The largest difference between two legs of what these times miss, with the same shift. [ns]
  [[nodiscard]] static std::int32_t error(const Wanted& wanted, std::int32_t shift_ns,
                                          const HighTimes& high_ns) noexcept {
    std::array<std::int32_t, 3> missed{};
    for (std::size_t n = 0; n < 3; ++n) {
      const std::int32_t ideal_ns = wanted.ideal_ns[n] + shift_ns;
      if (wanted.rests(ideal_ns)) continue;
      missed[n] = due_ns(wanted, n, shift_ns) - high_ns[n];
    }
    return std::max({missed[0], missed[1], missed[2]}) - std::min({missed[0], missed[1], missed[2]});
  }

  /// With the smallest error; of several the one with the zero vectors nearest to those demanded. But for
  /// these a leg rests, or is at an end of its admissible times: between such shifts the legs that miss their
  /// times do so by the same difference.
  [[nodiscard]] HighTimes best(const Wanted& wanted) const noexcept {
    Best found{realised(wanted, 0), 0, 0};
    found.error_ns = error(wanted, 0, found.high_ns);
    if (found.error_ns == 0) return found.high_ns;
    consider(wanted, -wanted.ideal_ns[2], found);
    consider(wanted, wanted.period_ns - wanted.ideal_ns[0], found);
    for (std::size_t n = 0; n < 3; ++n) {
      const std::int32_t due = due_ns(wanted, n, 0);
      consider(wanted, admissible_.shortest_high_ns - due, found);
      consider(wanted, wanted.period_ns - admissible_.shortest_low_ns - due, found);
    }
    return found.high_ns;
  }

  struct Best {
    HighTimes high_ns;
    std::int32_t error_ns;
    std::int32_t shift_ns;
  };
  void consider(const Wanted& wanted, std::int32_t shift_ns, Best& found) const noexcept {
    if (shift_ns < -wanted.ideal_ns[2] || shift_ns > wanted.period_ns - wanted.ideal_ns[0]) return;
    const HighTimes high_ns = realised(wanted, shift_ns);
    const std::int32_t error_ns = error(wanted, shift_ns, high_ns);
    if (error_ns > found.error_ns) return;
    if (error_ns == found.error_ns && std::abs(shift_ns) >= std::abs(found.shift_ns)) return;
    found = {high_ns, error_ns, shift_ns};
  }

  /// What a leg that switches is to be high for, up to a period beyond both ends of the period. [ns]
  [[nodiscard]] static std::int32_t due_ns(const Wanted& wanted, std::size_t n,
                                           std::int32_t shift_ns) noexcept {
    const T due = T(wanted.ideal_ns[n] + shift_ns) + wanted.longer_ns[n];
    return nearest_ns(due, wanted.period_ns) - beyond(due, wanted.period_ns);
  }

  /// By how much a time lies below zero, or above the period as a number below zero. [ns]
  [[nodiscard]] static std::int32_t beyond(T ns, std::int32_t period_ns) noexcept {
    return ns < T(0) ? nearest_ns(-ns, period_ns) : -nearest_ns(ns - T(period_ns), period_ns);
  }

  AdmissiblePulse admissible_;
};

}  // namespace sextant
