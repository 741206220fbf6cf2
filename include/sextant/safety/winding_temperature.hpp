#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Temperature of the stator winding by a thermal model of first order (IEC 60034-11, thermal protection;
/// IEC 60255-149, thermal relays):
///   τ dΔ/dt = Δ_n (i/i_n)² − Δ,   ϑ = ϑ_ambient + Δ
/// with the copper loss at constant resistance. Iron loss, the rotor's loss and the fan are not in it. The
/// mean of i² enters every 0.1 s: a step a period would be below the rounding of `float`. Without a nominal
/// current the temperature stays at the ambient one. It starts there too: nothing is kept over a power-down,
/// so a winding that was hot then is estimated too cold, by its rise times e^(−t/τ).
template <class T = double>
class WindingTemperature {
 public:
  struct Parameters {
    static constexpr T none = std::numeric_limits<T>::infinity();

    std::int32_t period_ns{25'000};  ///< control period [ns]
    T nominal_current{none};         ///< i_n, RMS of a phase in continuous operation; none: no model [A]
    T nominal_rise{T(80)};           ///< Δ_n, final temperature rise at that current [K]
    T time_constant{T(600)};         ///< τ [s]
    T ambient{T(40)};                ///< ϑ_ambient [°C]

    [[nodiscard]] const char* validate() const noexcept {
      if (period_ns <= 0) return "the control period must be above zero";
      if (!(nominal_current > T(0))) return "the winding's nominal current must be above zero";
      if (!(std::isfinite(nominal_rise) && nominal_rise > T(0))) {
        return "the winding's temperature rise must be above zero";
      }
      if (!(std::isfinite(time_constant) && time_constant >= T(1))) {
        return "the winding's thermal time constant must be at least a second";
      }
      return std::isfinite(ambient) ? nullptr : "the ambient temperature must be a number";
    }
  };

  explicit WindingTemperature(const Parameters& p) noexcept
      : parameters_{p},
        periods_a_step_{int(step_ns / p.period_ns) > 0 ? int(step_ns / p.period_ns) : 1},
        periods_left_{periods_a_step_},
        gain_{p.nominal_rise / (T(3) * T(periods_a_step_) * p.nominal_current * p.nominal_current)},
        share_{T(periods_a_step_) * T(p.period_ns) * T(1e-9) / p.time_constant},
        temperature_{p.ambient} {}

  /// One period with these phase currents [A].
  constexpr void step(const ThreePhase<T>& i) noexcept {
    if (gain_ == T(0)) return;
    sum_ += i.a * i.a + i.b * i.b + i.c * i.c;
    if (--periods_left_ > 0) return;
    temperature_ += share_ * (parameters_.ambient + gain_ * sum_ - temperature_);
    sum_ = T(0);
    periods_left_ = periods_a_step_;
  }

  [[nodiscard]] constexpr T temperature() const noexcept { return temperature_; }  ///< [°C]

 private:
  static constexpr std::int64_t step_ns = 100'000'000;

  Parameters parameters_;
  int periods_a_step_;
  int periods_left_;
  T gain_;   ///< from the sum of the squares over a step to the final rise; 0: no model [K/A²]
  T share_;  ///< of the way to the final temperature in a step [-]
  T sum_{};  ///< Σ i_a² + i_b² + i_c² of the step so far [A²]
  T temperature_;
};

}  // namespace sextant
