#pragma once

#include <algorithm>
#include <cmath>

namespace sextant {

/// Share of the torque that a band of the link voltage leaves: all of it up to one end, none beyond the
/// other, linear between. Below the nominal voltage it limits what motoring draws from a link that sags,
/// above it what regenerating feeds into a link that does not take it.
///
/// At constant speed the power P goes with the torque. Slowly seen it rises in the band with the voltage,
/// where a source of voltage E behind a resistance R delivers u (E − u)/R: the two meet in one point, and it
/// is stable but for the delay of the loop, by which a weak link may oscillate. Therefore the share follows
/// the mean of the voltage over `mean_time`, down at once and up at `return_rate` at most. Peak to peak it
/// can then move by no more than return_rate/f at a frequency f, 2 % at 100 Hz. A voltage that oscillates
/// because the power is constant goes on to: the band adds no damping when the voltage rises.
template <class T = double>
class LinkVoltageBand {
 public:
  struct Parameters {
    T full{};  ///< at which all of the torque is left; as `zero`: there is no band [V]
    T zero{};  ///< at which none is left [V]

    [[nodiscard]] constexpr bool acts() const noexcept { return full != zero; }

    /// It acts and does not fall from `full` below the nominal voltage to `zero` above this trip level [V].
    [[nodiscard]] constexpr bool is_wrong_below(T trip) const noexcept {
      return acts() && !(zero >= trip && zero < full);
    }
    /// It acts and does not fall from `full` above the nominal voltage to `zero` below this trip level [V].
    [[nodiscard]] constexpr bool is_wrong_above(T trip) const noexcept {
      return acts() && !(zero <= trip && zero > full && full > T(0));
    }

    [[nodiscard]] const char* validate() const noexcept {
      return std::isfinite(full) && std::isfinite(zero) && full >= T(0) && zero >= T(0)
                 ? nullptr
                 : "the ends of a band of the link voltage must be finite and not below zero";
    }
  };

  explicit constexpr LinkVoltageBand(const Parameters& p) noexcept
      : zero_{p.zero}, per_volt_{p.acts() ? T(1) / (p.full - p.zero) : T(0)} {}

  /// The link had this voltage [V] over dt [s]; no number is left out.
  constexpr void step(T u_dc, T dt) noexcept {
    if (per_volt_ == T(0) || !std::isfinite(u_dc)) return;
    if (!has_mean_) mean_ = u_dc;
    has_mean_ = true;
    mean_ += std::min(T(1), dt / mean_time) * (u_dc - mean_);
    const T left = std::clamp((mean_ - zero_) * per_volt_, T(0), T(1));
    share_ = std::min(left, share_ + return_rate * dt);
  }

  /// Takes the ends of another band; the mean of the voltage and the share stay.
  constexpr void take_parameters(const LinkVoltageBand& from) noexcept {
    zero_ = from.zero_;
    per_volt_ = from.per_volt_;
    if (per_volt_ == T(0)) *this = from;
  }

  [[nodiscard]] constexpr T share() const noexcept { return share_; }  ///< in [0, 1] [-]

 private:
  static constexpr T mean_time = T(1e-3);  // [s]
  static constexpr T return_rate = T(2);   // [1/s]

  T zero_;      ///< [V]
  T per_volt_;  ///< 1/(full − zero); 0: no band [1/V]
  T mean_{};    ///< [V]
  T share_{1};
  bool has_mean_{false};
};

}  // namespace sextant
