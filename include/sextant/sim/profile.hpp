#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// A value and the instant from which it counts.
struct ProfilePoint {
  double t_s{};    ///< from the beginning of the run [s]
  double value{};  ///< in the unit of what the profile drives
  friend constexpr bool operator==(ProfilePoint, ProfilePoint) noexcept = default;
};

/// How a profile goes from point to point.
enum class ProfileShape : std::uint8_t {
  constant,  ///< one value throughout
  steps,     ///< each value is held until the next point
  linear     ///< straight lines between the points, the last value held; two points at one time are a jump
};

struct ProfileParameters {
  ProfileShape shape{ProfileShape::constant};
  double value{0};                     ///< of a constant profile
  std::vector<ProfilePoint> points{};  ///< of steps and of a linear table, in order of time, the first at 0 s

  /// Empty when the profile is well formed, else what is wrong and, for a list, at which point (from 0).
  [[nodiscard]] std::string validate() const;
};

/// A quantity that a scenario prescribes over time: torque reference, load torque or imposed speed.
/// Times are rounded to the nanosecond. A jump counts from its own instant on.
class Profile {
 public:
  /// Zero throughout.
  Profile() : Profile{ProfileParameters{}} {}

  /// Throws std::runtime_error with the sentence of `validate()`.
  explicit Profile(const ProfileParameters& parameters);

  /// The value at t_ns; before 0 that of 0. [the profile's unit]
  [[nodiscard]] double value(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING;

  /// Right-hand derivative of a linear profile at t_ns, zero for the other shapes. [the profile's unit per s]
  [[nodiscard]] double slope(std::int64_t t_ns) const noexcept;

  /// The first instant after t_ns at which value or slope changes; far in the future when there is none. [ns]
  [[nodiscard]] std::int64_t next_corner_ns(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING;

  /// The instants at which the value jumps, in order; a run's step response starts at one of them. [ns]
  [[nodiscard]] const std::vector<std::int64_t>& jumps_ns() const noexcept { return jumps_ns_; }

 private:
  struct Segment {
    std::int64_t begin_ns{};
    double value{};
    double slope{};  // [1/s]
  };

  [[nodiscard]] const Segment& segment_at(std::int64_t t_ns) const noexcept;

  std::vector<Segment> segments_{};  // never empty, the first begins at 0
  std::vector<std::int64_t> jumps_ns_{};
};

}  // namespace sextant
