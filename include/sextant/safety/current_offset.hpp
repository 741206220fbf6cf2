#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sextant/core/measurement.hpp"

namespace sextant {

/// Offset of the current sensors: the mean of what they read at rest, with the gates off and no current.
///
/// Gates that are off are not yet rest: where the EMF exceeds the link, the diodes carry currents for some
/// rotor time constants. Those turn with the flux and decay, while an offset stands still. Rest is a run of
/// means over blocks of 1 ms, in each phase within
///   limit + step + 6 noise/√n        (n readings in a block)
/// of each other; a block beyond begins a new run. The mean counts from a run of `rest` on, and is judged
/// once it spans `average`: mostly 21 ms after the last current, at most 45 where the run began with the last
/// of it. Currents that turn by half a turn in `average`, from 25 Hz on, are no rest. While the gates are on
/// the last mean holds.
template <class T = double>
class CurrentOffset {
 public:
  struct Parameters {
    T limit{T(0.58)};                     ///< largest offset of a phase [A]
    T noise{T(0.2)};                      ///< standard deviation of a reading [A]
    T step{T(0)};                         ///< of the converters [A]
    std::int64_t rest_ns{10'000'000};     ///< [ns]
    std::int64_t average_ns{20'000'000};  ///< time constant of the mean, at least `rest` [ns]
  };

  constexpr explicit CurrentOffset(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// A usable measurement; the time since the last one is that of its applied pattern.
  void step(const Measurement<T>& measurement) noexcept {
    if (!is_off(measurement.applied)) {
      if (readings_ > 0 || run_ns_ > 0) begin_run();
      return;
    }
    const std::int64_t dt_ns = measurement.applied.duration_ns();
    if (dt_ns == 0) return;  // a period without a new measurement
    average(measurement.i_abc, dt_ns);
    add_to_block(measurement.i_abc, dt_ns);
  }

  /// The measurement without the offset, of which at most the limit is removed.
  [[nodiscard]] constexpr Measurement<T> removed_from(const Measurement<T>& measurement) const noexcept {
    Measurement<T> corrected = measurement;
    corrected.i_abc.a -= removed_.a;
    corrected.i_abc.b -= removed_.b;
    corrected.i_abc.c -= removed_.c;
    return corrected;
  }

  /// Takes the limits of another one between two measurements; the means stay.
  constexpr void take_parameters(const CurrentOffset& from) noexcept {
    parameters_ = from.parameters_;
    const T limit = parameters_.limit;
    each([&](auto phase) { removed_.*phase = std::clamp(removed_.*phase, -limit, limit); });
  }

  /// The means begin anew with the next rest: what a broken sensor has read is in them.
  constexpr void restart() noexcept {
    begin_run();
    removed_ = {};
    largest_ = T(0);
    is_known_ = true;
  }

  /// Largest magnitude of the three means; zero until they span their time constant. [A]
  [[nodiscard]] constexpr T largest() const noexcept { return largest_; }

 private:
  static constexpr std::int64_t block_ns = 1'000'000;
  static constexpr T infinity = std::numeric_limits<T>::infinity();
  static constexpr ThreePhase<T> highest{infinity, infinity, infinity};
  static constexpr ThreePhase<T> lowest{-infinity, -infinity, -infinity};

  [[nodiscard]] static constexpr bool is_off(const GatePattern& applied) noexcept {
    for (const GateSegment& segment : applied.segments()) {
      if (segment.state != gates_off) return false;
    }
    return true;
  }

  constexpr void begin_run() noexcept {
    run_ns_ = 0;
    least_ = highest;
    most_ = lowest;
    begin_block();
  }

  constexpr void begin_block() noexcept {
    sum_ = {};
    readings_ = 0;
    in_block_ns_ = 0;
  }

  /// The mean of all readings of the run until they span the time constant.
  void average(const ThreePhase<T>& i, std::int64_t dt_ns) noexcept {
    run_ns_ = std::min(run_ns_ + dt_ns, parameters_.average_ns);
    const T k = run_ns_ > dt_ns ? T(dt_ns) / T(run_ns_) : T(1);
    each([&](auto phase) { mean_.*phase += k * (i.*phase - mean_.*phase); });
    if (!is_known_) remove();  // at power-up, so that a drive may start at once
  }

  void add_to_block(const ThreePhase<T>& i, std::int64_t dt_ns) noexcept {
    each([&](auto phase) { sum_.*phase += i.*phase; });
    ++readings_;
    in_block_ns_ += dt_ns;
    if (in_block_ns_ < block_ns) return;
    end_block();
  }

  void end_block() noexcept {
    const T n = T(readings_);
    const T band = parameters_.limit + parameters_.step + T(6) * parameters_.noise / std::sqrt(n);
    bool stands_still = true;
    each([&](auto phase) {
      const T mean = sum_.*phase / n;
      least_.*phase = std::min(least_.*phase, mean);
      most_.*phase = std::max(most_.*phase, mean);
      stands_still = stands_still && most_.*phase - least_.*phase <= band;
    });
    if (!stands_still) return begin_run();
    begin_block();
    if (run_ns_ < parameters_.rest_ns) return;
    is_known_ = true;
    remove();
    if (run_ns_ == parameters_.average_ns) judge();
  }

  void remove() noexcept {
    const T limit = parameters_.limit;
    each([&](auto phase) { removed_.*phase = std::clamp(mean_.*phase, -limit, limit); });
  }

  void judge() noexcept {
    largest_ = T(0);
    each([&](auto phase) { largest_ = std::max(largest_, std::abs(mean_.*phase)); });
  }

  static constexpr void each(auto&& act) noexcept {
    for (const auto phase : {&ThreePhase<T>::a, &ThreePhase<T>::b, &ThreePhase<T>::c}) act(phase);
  }

  Parameters parameters_;
  ThreePhase<T> mean_{};          ///< over the run [A]
  ThreePhase<T> removed_{};       ///< mean within the limit [A]
  T largest_{};                   ///< magnitude of the means, once they span their time [A]
  bool is_known_{false};          ///< there has been a rest, or a fault
  std::int64_t run_ns_{};         ///< that the mean spans [ns]
  ThreePhase<T> least_{highest};  ///< mean of a block in the run [A]
  ThreePhase<T> most_{lowest};    ///< [A]
  ThreePhase<T> sum_{};           ///< of the block's readings [A]
  int readings_{};                ///< in the block [-]
  std::int64_t in_block_ns_{};    ///< [ns]
};

}  // namespace sextant
