#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "sextant/core/space_vector.hpp"
#include "sextant/safety/current_prediction.hpp"

namespace sextant {

/// The response of the three measured phase currents to the applied voltage. By the model of the machine
/// (`CurrentPrediction`) a period changes a current by p_k = v_k − e_k. Where n periods lie between two
/// measurements, Δi, v and e are the mean changes a period. In the second difference what is
/// constant in an error of the model cancels:
///   Δi_k ≈ p_k,   y = Δi_k − Δi_{k−1} ≈ w = p_k − p_{k−1} = v_k − v_{k−1} − d,   d = e_k − e_{k−1}
/// Per phase, over a window that forgets exponentially: Σ w y = response · Σ w², and the same of Σ p Δi and
/// Σ p². The response is near 1 for a phase that answers, 0 for one that is open or stuck, −1/2 on average
/// for one that is swapped with another. |y − w| is a jump that no voltage has caused, and no response to
/// one.
///
/// A phase is judged by what exceeds the error of the model. d, the rotation of e by ω_e T, may be wrong by
/// half of |d|, or of what an error of e turns by (`error_turn`), which counts as |d| where it is more: w
/// counts where Σ w² exceeds Σ |d|²/2. Along a saturated flux the transient inductance may be half of that of
/// the machine's parameters, and a change of the voltage act twice: a jump counts by as much as it exceeds
/// |d|/2 and |w|, both of the space vectors. p may be
/// wrong by its uncertainty: it counts where Σ p² exceeds four times the sum of the squares of that. Methods
/// whose voltage changes by active vectors from period to period are judged by w, down to four periods a
/// turn. A smooth voltage changes by little more than d: by w its methods are judged in transients; by p as
/// soon as a reading that does not answer makes them raise the voltage by more than twice e.
///
/// The second difference does not show readings that all stand still, under one voltage: for these, Σ (v − e)
/// less the mean error of the model before is the change that they ought to show. The error of e by the
/// machine's parameters, such as an inductance that is another at weakened flux, and that of v by the signs
/// of the currents turn with the machine, which the rotor shows but for the slip: the mean is that of the
/// error as the rotor turns it. An interval in which the current ought to change by more than twice what is
/// uncertain shows the error of the inductance, which a steady current does not have, and stays out of the
/// mean. By what is left it changes little from period to period: a quarter of the uncertainty, and of the
/// converter's step, is allowed for each. Readings within one step of the converter are equal. Only time with
/// every leg driven counts; each other interval starts anew.
template <class T = double>
class CurrentResponse {
 public:
  static constexpr std::size_t no_phase = 3;

  struct Parameters {
    std::int32_t period_ns{25'000};  ///< control period [ns]
    T jump{T(8)};                    ///< beyond |d|/2 + |w|: |y − w| above it stays out of the sums [A]
    T step{};                        ///< of the converter: readings that differ by no more are equal [A]
  };

  /// Sums over the window, of one phase.
  struct Sums {
    T answered{};   ///< Σ w y [A²]
    T expected{};   ///< Σ w² [A²]
    T uncertain{};  ///< what Σ w² must exceed for the errors of the model [A²]

    /// weight: periods that the terms stand for; forget: share of the sums that goes. [-]
    constexpr void add(T w, T y, T error, T weight, T forget) noexcept {
      answered += weight * w * y - forget * answered;
      expected += weight * w * w - forget * expected;
      uncertain += weight * error - forget * uncertain;
    }
    /// The voltage ought to have moved the current by enough: Σ w² above `least` [A²] and what is uncertain.
    [[nodiscard]] constexpr bool counts(T least) const noexcept { return expected > least + uncertain; }
    /// The response is below this one [-].
    [[nodiscard]] constexpr bool is_below(T response) const noexcept {
      return answered < response * expected;
    }
  };

  explicit CurrentResponse(const Parameters& parameters) noexcept
      : largest_jump_{parameters.jump},
        step_{parameters.step},
        forget_{std::min(T(1), T(parameters.period_ns) / T(window_ns))} {}

  /// The phase currents at the end of so many `periods` in which every leg was driven [A], and their
  /// predicted change.
  void step(const ThreePhase<T>& i, const PredictedChange<T>& change, T periods) noexcept {
    if (!has_reading_) return restart(i);
    const T share = T(1) / periods;
    const ThreePhase<T>& e = change.e;
    const SpaceVector<T> against = clarke(e);
    const SpaceVector<T> predicted = clarke(change.v) - against;
    const SpaceVector<T> emf = share * against;
    const SpaceVector<T> predicted_per_period = share * predicted;
    const T turned = T(0.5) * std::max(magnitude(emf - emf_), share * change.error_turn);
    const T explained = turned + magnitude(predicted_per_period - predicted_);
    const T uncertainty = share * change.uncertainty;
    const Interval interval{.periods = periods,
                            .share = share,
                            .forget = std::min(T(1), periods * forget_),
                            .explained = explained,
                            .uncertainty = uncertainty,
                            .of_w = T(2) * turned * turned,
                            .of_p = T(4) * uncertainty * uncertainty};
    emf_ = emf;
    predicted_ = predicted_per_period;
    jump_ = T(0);
    step(phases_[0], i.a, share * (change.v.a - e.a), interval);
    step(phases_[1], i.b, share * (change.v.b - e.b), interval);
    step(phases_[2], i.c, share * (change.v.c - e.c), interval);
    follow(interval, predicted, change.rotor_turn, clarke(i));
    has_predecessor_ = true;
  }

  /// An interval that does not count: i are the currents at its end [A].
  constexpr void restart(const ThreePhase<T>& i) noexcept {
    phases_ = {};
    phases_[0].i = phases_[0].still = i.a;
    phases_[1].i = phases_[1].still = i.b;
    phases_[2].i = phases_[2].still = i.c;
    i_s_ = clarke(i);
    error_ = {};
    has_reading_ = true;
    has_predecessor_ = false;
    jump_ = T(0);
    begin_still();
  }

  /// Takes the limits of another one of the same period; the sums stay.
  constexpr void take_parameters(const CurrentResponse& from) noexcept {
    largest_jump_ = from.largest_jump_;
    step_ = from.step_;
  }

  /// By w; phase n: 0 is a.
  [[nodiscard]] constexpr const Sums& phase(std::size_t n) const noexcept { return phases_[n].sums; }
  /// By p.
  [[nodiscard]] constexpr const Sums& change(std::size_t n) const noexcept { return phases_[n].change_sums; }
  /// True where phase n does not respond, by w, or by p, which hangs on the model of e, unless w shows that
  /// it answers. `noise`: variance of a reading [A²]; this changes a response by √6 σ/√(Σ w²), or √2 σ/√(Σ
  /// p²), and counts where that is below 1/16.
  [[nodiscard]] constexpr bool is_unresponsive(std::size_t n, T response, T noise) const noexcept {
    if (phase(n).counts(T(1536) * noise)) return phase(n).is_below(response);
    return change(n).counts(T(512) * noise) && change(n).is_below(response) && !answers(n, response, noise);
  }
  /// True where phase n responds, by w, with a noise of its response below 1/4 and by as much.
  [[nodiscard]] constexpr bool answers(std::size_t n, T response, T noise) const noexcept {
    return phase(n).counts(T(96) * noise) && !phase(n).is_below(response + T(0.25));
  }
  /// Largest |y − w| of the three phases at this measurement, beyond |d|/2 + |w|. [A]
  [[nodiscard]] constexpr T jump() const noexcept { return jump_; }
  /// While all readings stay equal: largest change of a phase current in that time by the model, beyond its
  /// uncertainty; zero otherwise. `open`: a phase without current, if there is one, which may be open, so
  /// that half of the voltage between the others is that of each. [A]
  [[nodiscard]] constexpr T hidden_change(std::size_t open = no_phase) const noexcept {
    const ThreePhase<T> by_phase = inverse_clarke(hidden_);
    const std::array hidden{by_phase.a, by_phase.b, by_phase.c};
    T largest{};
    for (std::size_t n = 0; n < 3; ++n) {
      const T between = T(0.5) * (hidden[(n + 1) % 3] - hidden[(n + 2) % 3]);
      if (open == no_phase || open == n) {
        largest = std::max(largest, std::abs(open == n ? between : hidden[n]));
      }
    }
    return std::max(T(0), largest - hidden_uncertainty_ - step_);
  }

 private:
  static constexpr std::int64_t window_ns = 3'000'000;  ///< time constant of the window [ns]

  struct State {
    T i{};          ///< at the last measurement [A]
    T still{};      ///< reading since which all are equal [A]
    T change{};     ///< last Δi [A]
    T predicted{};  ///< last v − e [A]
    Sums sums{};
    Sums change_sums{};
  };

  /// Between two measurements, of the currents a period.
  struct Interval {
    T periods{};      ///< its length [-]
    T share{};        ///< 1/periods [-]
    T forget{};       ///< share of the sums that goes [-]
    T explained{};    ///< |d|/2 + |w| of the space vector: |y − w| up to it is no jump [A]
    T uncertainty{};  ///< of p [A]
    T of_w{};         ///< |d|²/2: what is uncertain of w² [A²]
    T of_p{};         ///< four times the square of the uncertainty of p [A²]
  };

  constexpr void step(State& s, T i, T predicted, const Interval& in) noexcept {
    const T change = in.share * (i - s.i);
    const T w = predicted - s.predicted;
    const T y = change - s.change;
    s.i = i;
    s.change = change;
    s.predicted = predicted;
    if (!has_predecessor_) return;
    const T jump = std::abs(y - w) - in.explained;
    jump_ = std::max(jump_, jump);
    if (jump > largest_jump_) return;
    s.sums.add(w, y, in.of_w, in.periods, in.forget);
    s.change_sums.add(predicted, change, in.of_p, in.periods, in.forget);
  }

  [[nodiscard]] bool stands_still() const noexcept {
    const auto stands = [this](const State& s) { return std::abs(s.i - s.still) <= step_; };
    return stands(phases_[0]) && stands(phases_[1]) && stands(phases_[2]);
  }

  /// The readings begin to stand still.
  constexpr void begin_still() noexcept {
    hidden_ = missed_ = {};
    hidden_uncertainty_ = T(0);
    still_periods_ = T(0);
  }

  /// `predicted`: v − e over the interval [A], in which the rotor turned by `turn` [rad], to these currents
  /// [A].
  constexpr void follow(const Interval& in, SpaceVector<T> predicted, T turn, SpaceVector<T> i_s) noexcept {
    const SpaceVector<T> by_rotor = rotation(turn);
    error_ = product(by_rotor, error_);
    const SpaceVector<T> change = predicted - in.periods * error_;
    still_periods_ += in.periods;
    hidden_ += change;
    missed_ = product(by_rotor, missed_) + change - (i_s - i_s_);
    i_s_ = i_s;
    if (stands_still()) {
      hidden_uncertainty_ += T(0.25) * (in.periods * in.uncertainty + step_);
      return;
    }
    // Over all of the time since the readings stood still, or the noise of the one that ends it would count
    // whole: n periods have a weight of n/(n + 7).
    if (has_predecessor_ && magnitude(predicted) <= T(2) * in.periods * in.uncertainty)
      error_ += (T(1) / (still_periods_ + T(7))) * missed_;
    for (State& s : phases_) s.still = s.i;
    begin_still();
  }

  /// The unit vector at an angle, (1 + jh)²/(1 + h²) with h of half of it, whose own is off by a twelfth of
  /// the angle's cube.
  [[nodiscard]] static constexpr SpaceVector<T> rotation(T angle) noexcept {
    const T h = T(0.5) * angle;
    const T scale = T(1) / (T(1) + h * h);
    return {scale * (T(1) - h * h), scale * T(2) * h};
  }

  T largest_jump_;
  T step_;
  T forget_;                     ///< share of the sums that goes with a period [-]
  bool has_reading_{false};      ///< a measurement came before
  bool has_predecessor_{false};  ///< an interval that counts came before
  T jump_{};
  SpaceVector<T> error_{};      ///< mean of v − e − Δi a period, up to the last reading that changed [A]
  T still_periods_{};           ///< since all readings are equal [-]
  SpaceVector<T> hidden_{};     ///< Σ (v − e − error) since then [A]
  SpaceVector<T> missed_{};     ///< Σ (v − e − error − Δi) since then, as the rotor has turned meanwhile [A]
  T hidden_uncertainty_{};      ///< of `hidden_` [A]
  SpaceVector<T> i_s_{};        ///< at the last measurement [A]
  SpaceVector<T> emf_{};        ///< last e [A]
  SpaceVector<T> predicted_{};  ///< last v − e a period [A]
  std::array<State, 3> phases_{};
};

}  // namespace sextant
