#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "sextant/core/space_vector.hpp"
#include "sextant/safety/current_prediction.hpp"

namespace sextant {

/// Finds a phase that carries no current although it ought to. Its readings are those of no current, below z,
/// and stand still: a current that passes through zero moves by more than the noise, an open phase does not.
/// The true current moves by less than 2z meanwhile, and the sum of its predicted changes by no more than 2z
/// by the smallest response of a healthy phase (`CurrentPrediction`; v − e of an open phase is the voltage
/// that its controller raises in vain):
///   |Σ (v − e)| > 2z/response + Σ by_sign + Σ uncertainty  for `least_periods` or longer: the phase is open.
/// by_sign is what dead times take with the sign of a current, which readings near zero do not show: they may
/// hold a healthy current there.
/// A phase without current has no drop at R_s, so that the sum hangs on the change of the rotor flux alone.
/// At higher speed this grows with the uncertainty; there the turn of the rotor flux takes its place. A
/// healthy current of peak I is below z for a turn of 2 asin(z/I): after a turn of 0.35 rad + 8 z/I, more
/// than four times that, the sum must be above 2z/response + Σ by_sign alone. The turn counts where I is
/// above 4z. With one phase open, the voltage along it raises no current in the others either: all may be
/// without.
template <class T = double>
class PhaseContinuity {
 public:
  struct Parameters {
    T zero_current{T(2)};   ///< z: largest reading of a phase without current [A]
    T noise{T(1.2)};        ///< within which readings stand still [A]
    T response{T(0.35)};    ///< smallest of a healthy phase to a predicted change; 0: no phase is open [-]
    int least_periods{20};  ///< with such readings in a row [-]
  };

  explicit constexpr PhaseContinuity(const Parameters& parameters) noexcept
      : parameters_{parameters}, most_change_{T(2) * parameters.zero_current / parameters.response} {}

  /// The end of a period in which every leg was driven: currents [A] and their predicted change.
  void step(const ThreePhase<T>& i, const PredictedChange<T>& change) noexcept {
    const T peak = std::max({std::abs(i.a), std::abs(i.b), std::abs(i.c)});
    const T z = parameters_.zero_current;
    const T turn = peak > T(4) * z ? change.turn * peak / (T(0.35) * peak + T(8) * z) : T(0);
    step(phases_[0], i.a, change.v.a - change.e.a, change, turn);
    step(phases_[1], i.b, change.v.b - change.e.b, change, turn);
    step(phases_[2], i.c, change.v.c - change.e.c, change, turn);
  }

  constexpr void restart() noexcept { phases_ = {}; }

  /// Takes the limits of another one; what the phases have shown stays.
  constexpr void take_parameters(const PhaseContinuity& from) noexcept {
    parameters_ = from.parameters_;
    most_change_ = from.most_change_;
  }

  /// No phase has carried current in this period and the one before.
  [[nodiscard]] constexpr bool all_without_current() const noexcept {
    return std::min({phases_[0].below, phases_[1].below, phases_[2].below}) > 1;
  }
  /// Phase n has carried no current for `least_periods`: its readings stand still.
  [[nodiscard]] constexpr bool has_no_current(std::size_t n) const noexcept {
    return phases_[n].periods >= parameters_.least_periods;
  }
  /// Phase n carries no current although it ought to.
  [[nodiscard]] bool is_open(std::size_t n) const noexcept {
    const Phase& p = phases_[n];
    if (!has_no_current(n)) return false;
    const T error = std::abs(p.turn) > T(1) ? T(0) : p.uncertainty;
    return std::abs(p.unanswered) > most_change_ + p.by_sign + error;
  }

 private:
  /// Since the last reading of a current.
  struct Phase {
    int below{};      ///< readings below z, up to 2 [-]
    T still{};        ///< reading since which they stand still [A]
    int periods{};    ///< since then, up to the least that count [-]
    T unanswered{};   ///< Σ (v − e) [A]
    T by_sign{};      ///< of it, by the sign of the current [A]
    T uncertainty{};  ///< of it, beside [A]
    T turn{};         ///< of the rotor flux, by the most of a healthy phase [-]
  };

  void step(Phase& p, T i, T predicted, const PredictedChange<T>& change, T turn) noexcept {
    if (std::abs(i) >= parameters_.zero_current) {
      p = {};
      return;
    }
    p.below = std::min(p.below + 1, 2);
    if (p.periods == 0 || std::abs(i - p.still) > parameters_.noise) {
      p = {.below = p.below, .still = i, .periods = 1};  // the change that led here is none of these
      return;
    }
    p.periods = std::min(p.periods + 1, parameters_.least_periods);
    p.unanswered += predicted;
    p.by_sign += change.by_sign;
    p.uncertainty += change.uncertainty;
    p.turn += turn;
  }

  Parameters parameters_;
  T most_change_;  ///< predicted, of a healthy phase without current [A]
  std::array<Phase, 3> phases_{};
};

}  // namespace sextant
