#pragma once

#include <cmath>
#include <cstdint>

#include "sextant/core/measurement.hpp"

namespace sextant {

/// Offset of the current converters: the mean of what they measure while the gates are off and no current
/// flows, as at power-up and once the gates have been off for `rest`. A reading beyond
/// `largest` is no offset and is left out. While the gates are on the last offset holds.
template <class T = double>
class CurrentOffset {
 public:
  struct Parameters {
    T largest{T(4)};                      ///< of any phase [A]
    std::int64_t rest_ns{10'000'000};     ///< [ns]
    std::int64_t average_ns{20'000'000};  ///< time constant of the mean [ns]

    [[nodiscard]] const char* validate() const noexcept {
      if (!(std::isfinite(largest) && largest >= T(0))) return "the largest offset must not be below zero";
      if (rest_ns < 0 || average_ns <= 0) return "the times of the offset must be above zero";
      return nullptr;
    }
  };

  constexpr explicit CurrentOffset(const Parameters& parameters) noexcept
      : parameters_{parameters}, off_ns_{parameters.rest_ns} {}

  /// The measurement without the offset; the time since the last one is that of its applied pattern.
  [[nodiscard]] Measurement<T> step(const Measurement<T>& measurement) noexcept {
    const std::int64_t dt_ns = measurement.applied.duration_ns();
    if (!is_off(measurement.applied)) {
      off_ns_ = 0;
    } else {
      off_ns_ += dt_ns;
      if (off_ns_ > parameters_.rest_ns) average(measurement.i_abc, dt_ns);
    }
    Measurement<T> corrected = measurement;
    corrected.i_abc.a -= offset_.a;
    corrected.i_abc.b -= offset_.b;
    corrected.i_abc.c -= offset_.c;
    return corrected;
  }

 private:
  [[nodiscard]] static constexpr bool is_off(const GatePattern& applied) noexcept {
    for (const GateSegment& segment : applied.segments()) {
      if (segment.state != gates_off) return false;
    }
    return true;
  }

  void average(const ThreePhase<T>& i, std::int64_t dt_ns) noexcept {
    const bool small = std::abs(i.a) <= parameters_.largest && std::abs(i.b) <= parameters_.largest &&
                       std::abs(i.c) <= parameters_.largest;
    if (!small) return;
    // The mean of all readings until it spans the time constant.
    averaged_ns_ =
        averaged_ns_ + dt_ns < parameters_.average_ns ? averaged_ns_ + dt_ns : parameters_.average_ns;
    const T k = averaged_ns_ > dt_ns ? T(dt_ns) / T(averaged_ns_) : T(1);
    offset_.a += k * (i.a - offset_.a);
    offset_.b += k * (i.b - offset_.b);
    offset_.c += k * (i.c - offset_.c);
  }

  Parameters parameters_;
  ThreePhase<T> offset_{};
  std::int64_t off_ns_{};        ///< for which the gates have been off [ns]
  std::int64_t averaged_ns_{0};  ///< that the mean spans [ns]
};

}  // namespace sextant
