#pragma once

#include <cmath>
#include <cstdint>

namespace sextant {

/// Means of current, voltage, link voltage and speed over the periods of a level, each updated by its
/// difference:
///   m_n = m_{n−1} + (x_n − m_{n−1})/n
/// and the scatter of the current about its mean. Source: B. P. Welford, "Note on a method for calculating
/// corrected sums of squares and products", Technometrics 4 (1962) 419–420.
template <class T = double>
class LevelMeasurement {
 public:
  /// periods: those that the level is held for. [-]
  constexpr explicit LevelMeasurement(std::int32_t periods) noexcept : half_{periods / 2} {}

  /// One period: current [A], commanded mean voltage [V], link voltage [V] and mechanical speed [rad/s].
  constexpr void add(T i, T u, T u_dc, T omega_m) noexcept {
    ++count_;
    const T share = T(1) / T(count_);
    const T before = i - current_;
    current_ += share * before;
    squares_ += before * (i - current_);
    voltage_ += share * (u - voltage_);
    link_ += share * (u_dc - link_);
    speed_ += share * (omega_m - speed_);
    if (count_ == half_) first_half_ = voltage_;
  }

  [[nodiscard]] constexpr T current() const noexcept { return current_; }  ///< [A]
  [[nodiscard]] constexpr T voltage() const noexcept { return voltage_; }  ///< [V]
  [[nodiscard]] constexpr T link() const noexcept { return link_; }        ///< [V]
  [[nodiscard]] constexpr T speed() const noexcept { return speed_; }      ///< [rad/s]
  /// Standard deviation of the readings of the current. [A]
  [[nodiscard]] T scatter() const noexcept { return count_ > 1 ? std::sqrt(squares_ / T(count_ - 1)) : T(0); }
  /// Mean voltage of the second half less that of the first: what has not settled. [V]
  [[nodiscard]] constexpr T drift() const noexcept {
    return half_ > 0 && count_ > half_ ? T(2) * (voltage_ - first_half_) : T(0);
  }

 private:
  std::int32_t half_;      ///< [-]
  std::int32_t count_{0};  ///< periods [-]
  T current_{};            ///< [A]
  T squares_{};            ///< sum of squared deviations [A²]
  T voltage_{};            ///< [V]
  T link_{};               ///< [V]
  T speed_{};              ///< [rad/s]
  T first_half_{};         ///< mean voltage [V]
};

}  // namespace sextant
