#include "sextant/sim/profile.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

namespace sextant {
namespace {

// Well inside the range of 64-bit nanoseconds, which ends after 292 years.
constexpr double longest_time_s = 1e9;

std::int64_t to_ns(double t_s) noexcept {
  return std::llround(t_s * 1e9);
}

std::string validate_point(const std::vector<ProfilePoint>& points, std::size_t k, ProfileShape shape) {
  const auto [t_s, value] = points[k];
  if (!std::isfinite(t_s)) return fmt::format("point {}: the time must be finite", k);
  if (!std::isfinite(value)) return fmt::format("point {}: the value must be finite", k);
  if (t_s > longest_time_s)
    return fmt::format("point {}: the time must be at most {:g} s", k, longest_time_s);
  if (k == 0) {
    if (t_s != 0) return fmt::format("point 0: the first time must be 0 s, not {} s", t_s);
    return {};
  }
  const std::int64_t gap_ns = to_ns(t_s) - to_ns(points[k - 1].t_s);
  if (gap_ns < 0) return fmt::format("point {}: {} s is before point {}", k, t_s, k - 1);
  if (gap_ns == 0 && shape == ProfileShape::steps) {
    return fmt::format("point {}: {} s is the time of point {} too", k, t_s, k - 1);
  }
  return {};
}

}  // namespace

std::string ProfileParameters::validate() const {
  if (shape == ProfileShape::constant) {
    return std::isfinite(value) ? std::string{} : std::string{"the value must be finite"};
  }
  if (points.empty()) return "the list of points must not be empty";
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (std::string wrong = validate_point(points, k, shape); !wrong.empty()) return wrong;
  }
  return {};
}

Profile::Profile(const ProfileParameters& parameters) {
  if (const std::string wrong = parameters.validate(); !wrong.empty()) {
    throw std::runtime_error{"profile: " + wrong};
  }
  if (parameters.shape == ProfileShape::constant) {
    segments_.push_back({.begin_ns = 0, .value = parameters.value, .slope = 0});
    return;
  }
  const bool linear = parameters.shape == ProfileShape::linear;
  const auto& points = parameters.points;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const std::int64_t begin_ns = to_ns(points[k].t_s);
    const std::int64_t end_ns = k + 1 < points.size() ? to_ns(points[k + 1].t_s) : begin_ns;
    const double rise = end_ns > begin_ns ? points[k + 1].value - points[k].value : 0.0;
    const double slope = linear && rise != 0 ? rise / (double(end_ns - begin_ns) * 1e-9) : 0.0;
    segments_.push_back({.begin_ns = begin_ns, .value = points[k].value, .slope = slope});

    const bool can_jump = k > 0 && (!linear || to_ns(points[k - 1].t_s) == begin_ns);
    const bool is_new = jumps_ns_.empty() || jumps_ns_.back() != begin_ns;
    if (can_jump && is_new && points[k].value != points[k - 1].value) jumps_ns_.push_back(begin_ns);
  }
}

double Profile::value(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
  const Segment& s = segment_at(t_ns);
  return s.value + s.slope * (double(std::max(t_ns, std::int64_t{0}) - s.begin_ns) * 1e-9);
}

double Profile::slope(std::int64_t t_ns) const noexcept {
  return t_ns < 0 ? 0.0 : segment_at(t_ns).slope;
}

std::int64_t Profile::next_corner_ns(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
  const auto after = std::upper_bound(segments_.begin(), segments_.end(), t_ns,
                                      [](std::int64_t t, const Segment& s) { return t < s.begin_ns; });
  return after == segments_.end() ? std::numeric_limits<std::int64_t>::max() : after->begin_ns;
}

const Profile::Segment& Profile::segment_at(std::int64_t t_ns) const noexcept {
  const auto after = std::upper_bound(segments_.begin(), segments_.end(), t_ns,
                                      [](std::int64_t t, const Segment& s) { return t < s.begin_ns; });
  return after == segments_.begin() ? *after : *std::prev(after);
}

}  // namespace sextant
