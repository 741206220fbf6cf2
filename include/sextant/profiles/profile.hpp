#pragma once

#include <cstddef>
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

/// How a profile goes through time.
enum class ProfileShape : std::uint8_t {
  constant,  ///< one value throughout
  steps,     ///< each value is held until the next point
  linear,    ///< straight lines between the points, the last value held; two points at one time are a jump
  sine,      ///< value + amplitude · sin(2π · frequency · t + phase), as 2000 chords a period
  table      ///< as linear, its points from a file
};

struct ProfileParameters {
  ProfileShape shape{ProfileShape::constant};
  double value{0};                     ///< of a constant profile; offset of a sine [the profile's unit]
  std::vector<ProfilePoint> points{};  ///< of steps and lines, in order of time, the first at 0 s
  double amplitude{0};                 ///< of a sine [the profile's unit]
  double frequency_hz{1};              ///< of a sine [Hz]
  double phase_deg{0};                 ///< of a sine at time zero [°]
  std::string file{};                  ///< of a table; nothing but its name
  std::vector<ProfilePoint> table{};   ///< the points in that file

  /// Empty when the profile is well formed, else what is wrong and, for a list, at which point (from 0).
  [[nodiscard]] std::string validate() const;

  /// The list that the shape goes through; empty for the shapes without one.
  [[nodiscard]] const std::vector<ProfilePoint>& list() const noexcept {
    return shape == ProfileShape::table ? table : points;
  }
};

/// Empty when point k can follow the one before it in a list of that shape, else what is wrong.
[[nodiscard]] std::string validate_point(const std::vector<ProfilePoint>& points, std::size_t k,
                                         ProfileShape shape);

/// A quantity that a scenario prescribes over time: torque reference, load torque or imposed speed; piecewise
/// linear whatever its shape. Times are rounded to the nanosecond. A jump counts from its own instant on.
///
/// A sine is replaced by its chords between 2000 corners a period, which lie on it: the error is at most
/// (2π/2000)²/8 = 1.2e-6 of the amplitude. Chords are made as they are needed.
///
/// A lookup is cheap when it falls into the piece of the one before it, which is remembered: a profile
/// belongs to one thread.
class Profile {
 public:
  /// Zero throughout.
  Profile() : Profile{ProfileParameters{}} {}

  /// Throws std::runtime_error with the sentence of `validate()`.
  explicit Profile(const ProfileParameters& parameters);

  /// The value at t_ns; before 0 that of 0. [the profile's unit]
  [[nodiscard]] double value(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    const std::int64_t t = t_ns < 0 ? 0 : t_ns;
    const Piece& p = piece_at(t);
    return p.value + p.slope * (double(t - p.begin_ns) * 1e-9);
  }

  /// Right-hand derivative at t_ns, before 0 zero. [the profile's unit per s]
  [[nodiscard]] double slope(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    return t_ns < 0 ? 0.0 : piece_at(t_ns).slope;
  }

  /// The first instant after t_ns at which value or slope changes; far in the future when there is none. [ns]
  [[nodiscard]] std::int64_t next_corner_ns(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    return t_ns < 0 ? 0 : piece_at(t_ns).end_ns;
  }

  /// The instants at which the value jumps, in order. [ns]
  [[nodiscard]] const std::vector<std::int64_t>& jumps_ns() const noexcept { return jumps_ns_; }

 private:
  /// A straight line from begin_ns on and up to end_ns, without that instant.
  struct Piece {
    std::int64_t begin_ns{};
    std::int64_t end_ns{};
    double value{};  // at begin_ns
    double slope{};  // [1/s]
  };
  struct Sine {
    double offset{};
    double amplitude{};  // 0: the profile is no sine
    double omega{};      // [rad/s]
    double phase{};      // [rad]
    double chord_ns{};   // nominal length, not rounded [ns]
    [[nodiscard]] std::int64_t corner_ns(std::int64_t k) const noexcept;
    [[nodiscard]] double at(std::int64_t t_ns) const noexcept;
    [[nodiscard]] Piece piece_at(std::int64_t t_ns) const noexcept;
  };

  [[nodiscard]] const Piece& piece_at(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    if (t_ns < last_.begin_ns || t_ns >= last_.end_ns) last_ = find_piece(t_ns);
    return last_;
  }
  [[nodiscard]] Piece find_piece(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING;
  void add_list(const std::vector<ProfilePoint>& points, bool linear);

  std::vector<Piece> pieces_{};  // empty for a sine, else the first begins at 0
  Sine sine_{};
  std::vector<std::int64_t> jumps_ns_{};
  mutable Piece last_{};  // the piece of the last lookup
};

}  // namespace sextant
