#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sextant/core/measurement.hpp"

namespace sextant {

/// Offset of the current sensors: the mean of what they read while the gates are off and no current flows, as
/// at power-up and once the gates have been off for `rest`. While the gates are on the last mean holds. A
/// reading counts with at most four times the limit, so that a wild one is forgotten within 30 ms.
template <class T = double>
class CurrentOffset {
 public:
  struct Parameters {
    T limit{T(0.58)};                     ///< largest offset of a phase [A]
    std::int64_t rest_ns{10'000'000};     ///< [ns]
    std::int64_t average_ns{20'000'000};  ///< time constant of the mean [ns]
  };

  constexpr explicit CurrentOffset(const Parameters& parameters) noexcept
      : parameters_{parameters}, off_ns_{parameters.rest_ns} {}

  /// A usable measurement; the time since the last one is that of its applied pattern.
  void step(const Measurement<T>& measurement) noexcept {
    const std::int64_t dt_ns = measurement.applied.duration_ns();
    if (!is_off(measurement.applied)) {
      off_ns_ = 0;
      return;
    }
    off_ns_ += dt_ns;
    if (off_ns_ > parameters_.rest_ns) average(measurement.i_abc, dt_ns);
  }

  /// The measurement without the offset, of which at most the limit is removed.
  [[nodiscard]] constexpr Measurement<T> removed_from(const Measurement<T>& measurement) const noexcept {
    Measurement<T> corrected = measurement;
    corrected.i_abc.a -= removed_.a;
    corrected.i_abc.b -= removed_.b;
    corrected.i_abc.c -= removed_.c;
    return corrected;
  }

  /// The means begin anew, as at power-up: what a broken sensor has read is in them.
  constexpr void restart() noexcept {
    mean_ = removed_ = {};
    largest_ = T(0);
    averaged_ns_ = 0;
  }

  /// Largest magnitude of the three means; zero until they span their time constant. [A]
  [[nodiscard]] constexpr T largest() const noexcept { return largest_; }

 private:
  [[nodiscard]] static constexpr bool is_off(const GatePattern& applied) noexcept {
    for (const GateSegment& segment : applied.segments()) {
      if (segment.state != gates_off) return false;
    }
    return true;
  }

  void average(const ThreePhase<T>& i, std::int64_t dt_ns) noexcept {
    // The mean of all readings until it spans the time constant.
    averaged_ns_ = std::min(averaged_ns_ + dt_ns, parameters_.average_ns);
    const T k = averaged_ns_ > dt_ns ? T(dt_ns) / T(averaged_ns_) : T(1);
    const bool spans = averaged_ns_ == parameters_.average_ns;
    largest_ = T(0);
    for (const auto phase : {&ThreePhase<T>::a, &ThreePhase<T>::b, &ThreePhase<T>::c}) {
      T& mean = mean_.*phase;
      mean += k * (within(T(4) * parameters_.limit, i.*phase) - mean);
      removed_.*phase = within(parameters_.limit, mean);
      if (spans) largest_ = std::max(largest_, std::abs(mean));
    }
  }

  [[nodiscard]] static constexpr T within(T most, T x) noexcept { return std::clamp(x, -most, most); }

  Parameters parameters_;
  ThreePhase<T> mean_{};         ///< [A]
  ThreePhase<T> removed_{};      ///< mean within the limit [A]
  T largest_{};                  ///< magnitude of the means, once they span their time [A]
  std::int64_t off_ns_{};        ///< for which the gates have been off [ns]
  std::int64_t averaged_ns_{0};  ///< that the mean spans [ns]
};

}  // namespace sextant
