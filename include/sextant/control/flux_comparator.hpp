#pragma once

#include <array>
#include <cmath>

#include "sextant/control/threshold.hpp"
#include "sextant/core/description.hpp"

namespace sextant {

/// Two-level flux comparator: one relay on error = ψ_ref − |ψ_s| (paper, 2.2.2).
///   raise while the error is above −band after it last exceeded +band, else lower.
template <class T = double>
class FluxComparator {
 public:
  struct Parameters {
    T band{T(0.01)};  ///< half the width of the hysteresis [Wb]

    friend void describe(Description& d, Parameters& p, const Parameters& by_default) {
      auto& [half_width] = p;
      d.defaulted("flux_band_wb", half_width, by_default.band,
                  {"Wb", 1e-6, 1,
                   "half the width of the stator flux's hysteresis: the larger, the more its magnitude "
                   "ripples and the less it switches",
                   Changes::always});
    }

    [[nodiscard]] const char* validate() const noexcept {
      return std::isfinite(band) && band > T(0) ? nullptr : "the flux band must be above zero";
    }
  };

  constexpr explicit FluxComparator(const Parameters& parameters) noexcept {
    thresholds_[0].above = parameters.band;
    thresholds_[1].below = -parameters.band;
  }

  /// Updates the output by the flux error [Wb]; true: raise the flux, false: lower it.
  constexpr bool step(T error) noexcept {
    settle(*this, error);
    return raise_;
  }

  [[nodiscard]] constexpr bool output() const noexcept { return raise_; }

  /// The flux error [Wb] at which the present output changes.
  [[nodiscard]] constexpr Thresholds<T> thresholds() const noexcept { return thresholds_[raise_ ? 1 : 0]; }

  constexpr void on_crossing(int) noexcept { raise_ = !raise_; }

  constexpr void reset() noexcept { raise_ = true; }
  /// Takes the band of another one; the output stays until the next step.
  constexpr void take_parameters(const FluxComparator& from) noexcept { thresholds_ = from.thresholds_; }

 private:
  std::array<Thresholds<T>, 2> thresholds_{};  ///< by output
  bool raise_{true};
};

}  // namespace sextant
