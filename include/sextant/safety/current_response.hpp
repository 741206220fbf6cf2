#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "sextant/core/space_vector.hpp"

namespace sextant {

/// The response of the three measured phase currents to the applied voltage, by the transient model of the
/// machine (P. Vas, Sensorless Vector and Direct Torque Control, 1998):
///   σL_s di/dt = u − R_s i − e,   Δi_k = v_k − e_k,   v_k = ∫u_k dt / σL_s,
/// in which e_k, the change by R_s i + e, differs little from period to period. In the second difference it
/// cancels:
///   y = Δi_k − Δi_{k−1} = w − (e_k − e_{k−1}) ≈ w = v_k − v_{k−1}.
/// Per phase, over a window that forgets exponentially: Σ w y = response · Σ w². The response is near 1 for a
/// phase that answers, 0 for one that is open or stuck, −1/2 on average for one that is swapped with another.
/// |y − w| is a jump that no voltage has caused, and no response to one. The second difference does not show
/// readings that all stand still under one voltage vector: for these, v_k less the mean of e_k before adds up
/// to the change that they ought to show. Needs no parameter but σL_s. Only periods of the nominal length
/// with every leg driven count; each other one starts anew.
template <class T = double>
class CurrentResponse {
 public:
  struct Parameters {
    T sigma_l_s{T(0.004735)};        ///< transient stator inductance σL_s [H]
    std::int32_t period_ns{25'000};  ///< control period [ns]
    T jump{T(8)};                    ///< |y − w| above it stays out of the sums [A]
  };

  /// The sums of one phase.
  struct Phase {
    T answered{};  ///< Σ w y [A²]
    T expected{};  ///< Σ w² [A²]

    /// True where the voltage ought to have moved the current by enough (Σ w² above `least` [A²]), and the
    /// response is below `response` [-].
    [[nodiscard]] constexpr bool is_unresponsive(T response, T least) const noexcept {
      return expected > least && answered < response * expected;
    }
  };

  explicit CurrentResponse(const Parameters& parameters) noexcept
      : inverse_inductance_{T(1) / parameters.sigma_l_s},
        largest_jump_{parameters.jump},
        forget_{std::min(T(1), T(parameters.period_ns) / T(window_ns))} {}

  /// The phase currents at the end of a period in which every leg was driven [A], and ∫u_x dt over it [V·s].
  constexpr void step(const ThreePhase<T>& i, const ThreePhase<T>& volt_seconds) noexcept {
    const bool stands_still = i == ThreePhase<T>{phases_[0].i, phases_[1].i, phases_[2].i};
    jump_ = T(0);
    step(phases_[0], i.a, volt_seconds.a);
    step(phases_[1], i.b, volt_seconds.b);
    step(phases_[2], i.c, volt_seconds.c);
    if (stands_still) {
      add_hidden_change();
    } else {
      follow();
    }
    has_predecessor_ = true;
  }

  /// A period that does not count: i are the currents at its end [A].
  constexpr void restart(const ThreePhase<T>& i) noexcept {
    phases_ = {};
    phases_[0].i = i.a;
    phases_[1].i = i.b;
    phases_[2].i = i.c;
    has_predecessor_ = false;
    jump_ = T(0);
    hidden_change_ = T(0);
  }

  /// Phase n: 0 is a.
  [[nodiscard]] constexpr const Phase& phase(std::size_t n) const noexcept { return phases_[n].sums; }
  /// Largest |y − w| of the three phases in this period. [A]
  [[nodiscard]] constexpr T jump() const noexcept { return jump_; }
  /// While all readings stay the same to the last digit: largest change of a phase current in that time by
  /// the model; zero otherwise. [A]
  [[nodiscard]] constexpr T hidden_change() const noexcept { return hidden_change_; }

 private:
  static constexpr std::int64_t window_ns = 3'000'000;  ///< time constant of the window [ns]

  struct State {
    T i{};       ///< at the last measurement [A]
    T v{};       ///< v of the last period [A]
    T e{};       ///< e of the last period [A]
    T e_mean{};  ///< mean of e over the last periods in which a reading changed [A]
    T hidden{};  ///< Σ (v − e_mean) since then [A]
    Phase sums{};
  };

  constexpr void step(State& s, T i, T volt_seconds) noexcept {
    const T v = volt_seconds * inverse_inductance_;
    const T e = v - (i - s.i);
    const T w = v - s.v;
    const T unexplained = e - s.e;  // w − y
    s.i = i;
    s.v = v;
    s.e = e;
    if (!has_predecessor_) return;
    jump_ = std::max(jump_, std::abs(unexplained));
    if (std::abs(unexplained) > largest_jump_) return;
    s.sums.answered += w * (w - unexplained) - forget_ * s.sums.answered;
    s.sums.expected += w * w - forget_ * s.sums.expected;
  }

  /// Readings that change.
  constexpr void follow() noexcept {
    for (State& s : phases_) {
      // The reading before a first period may be none.
      if (has_predecessor_) s.e_mean += T(0.125) * (s.e - s.e_mean);
      s.hidden = T(0);
    }
    hidden_change_ = T(0);
  }

  /// Readings that stand still.
  constexpr void add_hidden_change() noexcept {
    hidden_change_ = T(0);
    for (State& s : phases_) {
      s.hidden += s.v - s.e_mean;
      hidden_change_ = std::max(hidden_change_, std::abs(s.hidden));
    }
  }

  T inverse_inductance_;
  T largest_jump_;
  T forget_;
  bool has_predecessor_{false};  ///< a period that counts came before
  T jump_{};
  T hidden_change_{};
  std::array<State, 3> phases_{};
};

}  // namespace sextant
