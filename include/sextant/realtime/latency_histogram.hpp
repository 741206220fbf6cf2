#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// The figures of a histogram that people read.
struct LatencySummary {
  std::uint64_t count{};     ///< samples [-]
  double mean_ns{};          ///< [ns]
  std::int64_t p50_ns{};     ///< median [ns]
  std::int64_t p99_ns{};     ///< [ns]
  std::int64_t p99_9_ns{};   ///< [ns]
  std::int64_t p99_99_ns{};  ///< [ns]
  std::int64_t max_ns{};     ///< exact [ns]
};

/// Histogram of durations in fixed memory. Buckets are log-linear: every octave is cut into 64 equal parts,
/// so that a bucket's middle is within 1/128 (0.8 %) of every value in it; below 128 ns each value has its
/// own bucket. Durations from 0 to 2^40 ns (18 minutes) are distinguished; shorter count as 0, longer as the
/// last bucket. The maximum is kept exactly.
///
/// One thread records. The object is trivially copyable: it goes to a reader by copying it into a
/// LatestValue.
class LatencyHistogram {
 public:
  /// Adds a duration [ns].
  void record(std::int64_t duration_ns) noexcept SEXTANT_NONBLOCKING {
    const std::int64_t d = duration_ns < 0 ? 0 : duration_ns;
    ++buckets_[bucket_of(d)];
    ++count_;
    sum_ns_ += static_cast<double>(d);
    if (d > max_ns_) max_ns_ = d;
  }

  void reset() noexcept SEXTANT_NONBLOCKING { *this = LatencyHistogram{}; }

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  /// The longest duration, exactly; 0 while there is none. [ns]
  [[nodiscard]] std::int64_t max_ns() const noexcept { return max_ns_; }
  [[nodiscard]] double mean_ns() const noexcept {
    return count_ == 0 ? 0.0 : sum_ns_ / static_cast<double>(count_);
  }

  /// The nearest-rank percentile, 0 < percent <= 100: the smallest duration that at least so many per cent of
  /// the samples do not exceed, to 0.8 %; 0 while there are no samples. [ns]
  [[nodiscard]] std::int64_t percentile_ns(double percent) const noexcept {
    if (count_ == 0) return 0;
    const double wanted = std::ceil(std::clamp(percent, 0.0, 100.0) / 100.0 * static_cast<double>(count_));
    const std::uint64_t rank = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(wanted));
    std::uint64_t below = 0;
    for (std::size_t i = 0; i + 1 < bucket_count; ++i) {
      below += buckets_[i];
      if (below >= rank) return std::min(middle_of(i), max_ns_);
    }
    return max_ns_;
  }

  [[nodiscard]] LatencySummary summary() const noexcept {
    return {count_,
            mean_ns(),
            percentile_ns(50.0),
            percentile_ns(99.0),
            percentile_ns(99.9),
            percentile_ns(99.99),
            max_ns_};
  }

  /// Calls f(middle [ns], count) for every bucket that holds samples, the shortest first.
  template <class F>
  void for_each_bucket(F&& f) const {
    for (std::size_t i = 0; i < bucket_count; ++i) {
      if (buckets_[i] > 0) f(std::min(middle_of(i), max_ns_), buckets_[i]);
    }
  }

 private:
  static constexpr int linear_bits = 7;  // values of so many bits have buckets of their own
  static constexpr int range_bits = 40;
  static constexpr std::size_t per_octave = std::size_t{1} << (linear_bits - 1);
  static constexpr std::size_t bucket_count = 2 * per_octave + (range_bits - linear_bits) * per_octave;

  [[nodiscard]] static constexpr std::size_t bucket_of(std::int64_t d) noexcept {
    const auto v = static_cast<std::uint64_t>(d);
    const int shift = std::max(0, static_cast<int>(std::bit_width(v)) - linear_bits);
    const std::size_t i = static_cast<std::size_t>(shift) * per_octave + static_cast<std::size_t>(v >> shift);
    return std::min(i, bucket_count - 1);
  }

  [[nodiscard]] static constexpr std::int64_t middle_of(std::size_t bucket) noexcept {
    if (bucket < 2 * per_octave) return static_cast<std::int64_t>(bucket);
    const std::size_t shift = bucket / per_octave - 1;
    const std::size_t low = (bucket - shift * per_octave) << shift;
    return static_cast<std::int64_t>(low + (std::size_t{1} << (shift - 1)));
  }

  std::array<std::uint64_t, bucket_count> buckets_{};
  std::uint64_t count_{0};
  double sum_ns_{0.0};
  std::int64_t max_ns_{0};
};

}  // namespace sextant
