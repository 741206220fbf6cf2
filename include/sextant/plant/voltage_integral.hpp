#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/two_level_inverter.hpp"
#include "sextant/plant/smooth_state.hpp"

namespace sextant {

/// The integral V(t) = ∫ u_s dt of the stator voltage from the beginning of gate segments that follow each
/// other with every leg driven: a polygon with its corners where the inverter switches, known in closed form.
/// Times count from its beginning. [s]
template <class T = double>
class VoltageIntegral {
 public:
  /// The segments must be driven, GatePattern::capacity at most. lost: a constant voltage that thresholds
  /// take. Voltages [V].
  VoltageIntegral(std::span<const GateSegment> segments, T u_dc,
                  SpaceVector<T> lost = {}) noexcept SEXTANT_NONBLOCKING {
    for (const GateSegment& segment : segments)
      append(stator_voltage(segment.state, u_dc) - lost, segment.duration_ns);
  }

  /// V and A = ∫ V dt from the beginning to t.
  [[nodiscard]] VoltageMoments<T> operator()(T t) const noexcept SEXTANT_NONBLOCKING {
    std::size_t k = 0;
    while (k + 1 < count_ && t >= pieces_[k].end) ++k;
    return within(k, t);
  }
  /// The same at a time within segment k.
  [[nodiscard]] VoltageMoments<T> within(std::size_t k, T t) const noexcept SEXTANT_NONBLOCKING {
    const Piece& p = pieces_[k];
    return moved(p.at_begin, p.u_s, t - p.begin);
  }

  /// ∫ A dt over all segments. [Wb·s²]
  [[nodiscard]] SpaceVector<T> area_of_a() const noexcept SEXTANT_NONBLOCKING { return area_of_a_; }
  /// How long they last together. [s]
  [[nodiscard]] T duration() const noexcept SEXTANT_NONBLOCKING { return T(1e-9) * T(duration_ns_); }
  /// The same. [ns]
  [[nodiscard]] std::int64_t duration_ns() const noexcept SEXTANT_NONBLOCKING { return duration_ns_; }
  /// V and A at the end.
  [[nodiscard]] const VoltageMoments<T>& end() const noexcept SEXTANT_NONBLOCKING { return end_; }

  [[nodiscard]] std::size_t size() const noexcept SEXTANT_NONBLOCKING { return count_; }
  /// End of segment k. [s]
  [[nodiscard]] T corner(std::size_t k) const noexcept SEXTANT_NONBLOCKING { return pieces_[k].end; }
  /// V and A at the end of segment k.
  [[nodiscard]] const VoltageMoments<T>& at_corner(std::size_t k) const noexcept SEXTANT_NONBLOCKING {
    return k + 1 < count_ ? pieces_[k + 1].at_begin : end_;
  }

 private:
  struct Piece {
    T begin{};             ///< [s]
    T end{};               ///< [s]
    SpaceVector<T> u_s{};  ///< [V]
    VoltageMoments<T> at_begin{};
  };

  static VoltageMoments<T> moved(const VoltageMoments<T>& m, SpaceVector<T> u_s,
                                 T t) noexcept SEXTANT_NONBLOCKING {
    return {m.v + t * u_s, m.a + t * (m.v + (T(0.5) * t) * u_s)};
  }

  void append(SpaceVector<T> u_s, std::int64_t duration_ns) noexcept SEXTANT_NONBLOCKING {
    const T begin = T(1e-9) * T(duration_ns_);
    duration_ns_ += duration_ns;
    pieces_[count_++] = {begin, T(1e-9) * T(duration_ns_), u_s, end_};
    const T t = T(1e-9) * T(duration_ns);
    area_of_a_ += t * (end_.a + t * (T(0.5) * end_.v + (t / T(6)) * u_s));
    end_ = moved(end_, u_s, t);
  }

  std::array<Piece, GatePattern::capacity> pieces_{};
  std::size_t count_{0};
  std::int64_t duration_ns_{0};
  VoltageMoments<T> end_{};
  SpaceVector<T> area_of_a_{};  ///< [Wb·s²]
};

}  // namespace sextant
