#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "sextant/profiles/profile.hpp"

namespace sextant {

/// The longest time for which a vehicle left the band around its cycle.
struct CycleDeparture {
  std::int64_t from_ns{};      ///< beginning [ns]
  std::int64_t duration_ns{};  ///< [ns]
  double farthest{};           ///< largest distance from the speeds of the cycle within a second [m/s]
};

/// Whether a vehicle follows the speed of a cycle. The band is 2 km/h above the highest and below the lowest
/// speed of the cycle within a second before and after; outside of it the vehicle may be for a second at a
/// time. Source: UN Global Technical Regulation No. 15 (WLTP), Annex 6, speed trace tolerances. The speed is
/// looked at every 10 ms.
class CycleFollowing {
 public:
  static constexpr double tolerance = 2.0 / 3.6;                ///< [m/s]
  static constexpr std::int64_t around_ns = 1'000'000'000;      ///< before and after, of the cycle [ns]
  static constexpr std::int64_t longest_ns = 1'000'000'000;     ///< outside of the band at a time [ns]
  static constexpr std::int64_t between_looks_ns = 10'000'000;  ///< [ns]

  /// The cycle's speed [m/s]; throws std::runtime_error with the sentence of `validate()`.
  explicit CycleFollowing(const ProfileParameters& speed) : speed_{speed} {}

  /// The vehicle's speed at t_ns, which must not fall. [m/s]
  void add(std::int64_t t_ns, double speed) noexcept {
    if (t_ns < next_ns_) return;
    next_ns_ = t_ns + between_looks_ns;
    const Band cycle = around(t_ns);
    const double distance = std::max(speed - cycle.highest, cycle.lowest - speed);
    // A speed that is no number follows nothing.
    if (distance <= tolerance) {
      outside_.reset();
      return;
    }
    if (!outside_) outside_ = CycleDeparture{.from_ns = t_ns};
    outside_->duration_ns = t_ns - outside_->from_ns;
    outside_->farthest = std::max(outside_->farthest, distance);
    if (outside_->duration_ns >= longest_.duration_ns) longest_ = *outside_;
  }

  /// Empty where the vehicle followed.
  [[nodiscard]] std::optional<CycleDeparture> departure() const noexcept {
    if (longest_.duration_ns <= longest_ns) return std::nullopt;
    return longest_;
  }

 private:
  struct Band {
    double lowest{};
    double highest{};
    void take(double speed) noexcept {
      lowest = std::min(lowest, speed);
      highest = std::max(highest, speed);
    }
  };

  /// Lowest and highest speed of the cycle around t_ns.
  [[nodiscard]] Band around(std::int64_t t_ns) const noexcept {
    const std::int64_t begin_ns = std::max<std::int64_t>(0, t_ns - around_ns);
    const std::int64_t end_ns = t_ns + around_ns;
    Band band{speed_.value(begin_ns), speed_.value(begin_ns)};
    for (std::int64_t corner = speed_.next_corner_ns(begin_ns); corner <= end_ns;
         corner = speed_.next_corner_ns(corner)) {
      band.take(speed_.value(corner - 1));
      band.take(speed_.value(corner));
    }
    band.take(speed_.value(end_ns));
    return band;
  }

  Profile speed_;
  std::int64_t next_ns_{0};
  std::optional<CycleDeparture> outside_{};  // since the vehicle left the band
  CycleDeparture longest_{};
};

}  // namespace sextant
