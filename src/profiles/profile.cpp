#include "sextant/profiles/profile.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

namespace sextant {
namespace {

// Well inside the range of 64-bit nanoseconds, which ends after 292 years.
constexpr double longest_time_s = 1e9;
constexpr std::int64_t never_ns = std::numeric_limits<std::int64_t>::max();
constexpr int chords_per_period = 2000;
// A chord then lasts 500 ns, and rounding its ends to the nanosecond does not count.
constexpr double highest_frequency_hz = 1000;

std::int64_t to_ns(double t_s) noexcept {
  return std::llround(t_s * 1e9);
}

std::string validate_sine(const ProfileParameters& p) {
  if (!std::isfinite(p.value)) return "the value must be finite";
  if (!std::isfinite(p.amplitude)) return "the amplitude must be finite";
  if (!std::isfinite(p.phase_deg)) return "the phase must be finite";
  if (!(p.frequency_hz >= 1.0 / longest_time_s && p.frequency_hz <= highest_frequency_hz))
    return fmt::format("the frequency must be from {:g} to {:g} Hz", 1.0 / longest_time_s,
                       highest_frequency_hz);
  return {};
}

}  // namespace

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
  if (gap_ns < 0)
    return fmt::format("point {}: the time goes back from {} to {} s", k, points[k - 1].t_s, t_s);
  if (gap_ns == 0 && shape == ProfileShape::steps) {
    return fmt::format("point {}: {} s is the time of point {} too", k, t_s, k - 1);
  }
  return {};
}

std::string ProfileParameters::validate() const {
  if (shape == ProfileShape::constant) {
    return std::isfinite(value) ? std::string{} : std::string{"the value must be finite"};
  }
  if (shape == ProfileShape::sine) return validate_sine(*this);
  if (shape == ProfileShape::table && table.empty()) return "a table needs the key file";
  if (list().empty()) return "the list of points must not be empty";
  for (std::size_t k = 0; k < list().size(); ++k) {
    if (std::string wrong = validate_point(list(), k, shape); !wrong.empty()) return wrong;
  }
  if (list().size() > 1 && list().back().t_s == 0) return "the time stands still at 0 s in every point";
  return {};
}

Profile::Profile(const ProfileParameters& parameters) {
  if (const std::string wrong = parameters.validate(); !wrong.empty()) {
    throw std::runtime_error{"profile: " + wrong};
  }
  if (parameters.shape == ProfileShape::sine && parameters.amplitude != 0) {
    const double f = parameters.frequency_hz;
    sine_ = {parameters.value, parameters.amplitude, 2.0 * std::numbers::pi * f,
             parameters.phase_deg * std::numbers::pi / 180.0, 1e9 / (f * chords_per_period)};
  } else if (parameters.list().empty() || parameters.shape == ProfileShape::constant ||
             parameters.shape == ProfileShape::sine) {
    pieces_.push_back({.begin_ns = 0, .end_ns = never_ns, .value = parameters.value, .slope = 0});
  } else {
    add_list(parameters.list(), parameters.shape != ProfileShape::steps);
  }
  last_ = find_piece(0);
}

void Profile::add_list(const std::vector<ProfilePoint>& points, bool linear) {
  for (std::size_t k = 0; k < points.size(); ++k) {
    const std::int64_t begin_ns = to_ns(points[k].t_s);
    const std::int64_t end_ns = k + 1 < points.size() ? to_ns(points[k + 1].t_s) : never_ns;
    const bool rises = linear && end_ns > begin_ns && end_ns != never_ns;
    const double rise = rises ? points[k + 1].value - points[k].value : 0.0;
    const double slope = rise != 0 ? rise / (double(end_ns - begin_ns) * 1e-9) : 0.0;
    pieces_.push_back({.begin_ns = begin_ns, .end_ns = end_ns, .value = points[k].value, .slope = slope});

    const bool can_jump = k > 0 && (!linear || to_ns(points[k - 1].t_s) == begin_ns);
    const bool is_new = jumps_ns_.empty() || jumps_ns_.back() != begin_ns;
    if (can_jump && is_new && points[k].value != points[k - 1].value) jumps_ns_.push_back(begin_ns);
  }
}

Profile::Piece Profile::find_piece(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
  // Far enough from the end of 64-bit nanoseconds for the corner after it.
  if (pieces_.empty()) return sine_.piece_at(std::min(t_ns, to_ns(longest_time_s)));
  const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), t_ns,
                                      [](std::int64_t t, const Piece& p) { return t < p.begin_ns; });
  return after == pieces_.begin() ? *after : *std::prev(after);
}

std::int64_t Profile::Sine::corner_ns(std::int64_t k) const noexcept {
  return std::llround(double(k) * chord_ns);
}

double Profile::Sine::at(std::int64_t t_ns) const noexcept {
  return offset + amplitude * std::sin(omega * (double(t_ns) * 1e-9) + phase);
}

Profile::Piece Profile::Sine::piece_at(std::int64_t t_ns) const noexcept {
  auto k = static_cast<std::int64_t>(double(t_ns) / chord_ns);
  if (corner_ns(k) > t_ns) --k;
  if (corner_ns(k + 1) <= t_ns) ++k;
  const std::int64_t begin = corner_ns(k);
  const std::int64_t end = corner_ns(k + 1);
  const double value = at(begin);
  return {begin, end, value, (at(end) - value) / (double(end - begin) * 1e-9)};
}

}  // namespace sextant
