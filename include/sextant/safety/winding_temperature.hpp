#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "sextant/core/description.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Temperature of the stator winding by a thermal model of first order (IEC 60034-11, thermal protection;
/// IEC 60255-149, thermal relays):
///   τ dΔ/dt = Δ_n (i/i_n)² − Δ,   ϑ = ϑ_ambient + Δ
/// with the copper loss at constant resistance. Iron loss, the rotor's loss and the fan are not in it. The
/// mean of i² over time enters every 0.1 s: a step a period would be below the rounding of `float`. Without a
/// nominal current the temperature stays at the ambient one. It starts there too: nothing is kept over a
/// power-down, so a winding that was hot then is estimated too cold, by its rise times e^(−t/τ). A measured
/// temperature takes the place of the model's every 0.1 s, and the model goes on from the last one.
template <class T = double>
class WindingTemperature {
 public:
  struct Parameters {
    static constexpr T none = std::numeric_limits<T>::infinity();

    T nominal_current{none};  ///< i_n, RMS of a phase in continuous operation; none: no model [A]
    T nominal_rise{T(80)};    ///< Δ_n, final temperature rise at that current [K]
    T time_constant{T(600)};  ///< τ [s]
    T ambient{T(40)};         ///< ϑ_ambient [°C]

    [[nodiscard]] const char* validate() const noexcept {
      if (!(nominal_current > T(0))) return "the winding's nominal current must be above zero";
      if (!(std::isfinite(nominal_rise) && nominal_rise > T(0))) {
        return "the winding's temperature rise must be above zero";
      }
      if (!(std::isfinite(time_constant) && time_constant >= T(1))) {
        return "the winding's thermal time constant must be at least a second";
      }
      return std::isfinite(ambient) ? nullptr : "the ambient temperature must be a number";
    }

    friend void describe(Description& d, Parameters& p) {
      auto& [current, rise, constant, surroundings] = p;
      d.number("nominal_current_a", NumberMember::unless_infinite(current),
               {"A", 1e-3, 1e5,
                "RMS of a phase current that the winding bears for good, by the nameplate, for a thermal "
                "model of it; not set: no model, and the winding is not protected",
                Changes::always});
      d.number("nominal_rise_k", rise,
               {"K", 1, 500, "final temperature rise of the winding at nominal_current_a", Changes::always});
      d.number("time_constant_s", constant,
               {"s", 1, 1e5, "thermal time constant of the winding", Changes::always});
      d.number("ambient_c", surroundings,
               {"C", -100, 200,
                "temperature of the winding without current, also at power-up: a winding that is still warm "
                "then counts as cold, for some time constants",
                Changes::always});
    }
  };

  explicit WindingTemperature(const Parameters& p) noexcept
      : parameters_{p},
        gain_{p.nominal_rise / (T(3) * p.nominal_current * p.nominal_current)},
        temperature_{p.ambient} {}

  /// These phase currents [A] flowed for duration_ns [ns]; measured: temperature, finite, where there is a
  /// sensor [°C].
  constexpr void step(const ThreePhase<T>& i, std::int64_t duration_ns,
                      const std::optional<T>& measured = {}) noexcept {
    if (measured && !was_measured_) temperature_ = *measured;
    was_measured_ = was_measured_ || measured;
    if (!is_known()) return;
    sum_ += seconds(duration_ns) * (i.a * i.a + i.b * i.b + i.c * i.c);
    elapsed_ns_ += duration_ns;
    if (elapsed_ns_ < step_ns) return;
    const T elapsed = seconds(elapsed_ns_);
    if (measured) {
      temperature_ = *measured;
    } else if (gain_ > T(0)) {
      const T share = std::min(T(1), elapsed / parameters_.time_constant);
      temperature_ += share * (parameters_.ambient + gain_ * sum_ / elapsed - temperature_);
    }
    sum_ = T(0);
    elapsed_ns_ = 0;
  }

  /// Takes the parameters of another one; the temperature stays where it is known before and after.
  constexpr void take_parameters(const WindingTemperature& from) noexcept {
    if (!is_known()) temperature_ = from.temperature_;
    parameters_ = from.parameters_;
    gain_ = from.gain_;
    if (!is_known()) temperature_ = from.temperature_;
  }

  [[nodiscard]] constexpr T temperature() const noexcept { return temperature_; }  ///< [°C]
  /// There is a model or has been a measurement; else `temperature` is the ambient one.
  [[nodiscard]] constexpr bool is_known() const noexcept { return gain_ > T(0) || was_measured_; }

 private:
  static constexpr std::int64_t step_ns = 100'000'000;

  [[nodiscard]] static constexpr T seconds(std::int64_t ns) noexcept { return T(ns) * T(1e-9); }

  Parameters parameters_;
  T gain_;                      ///< from the mean of Σ i² to the final rise; 0: no model [K/A²]
  T sum_{};                     ///< ∫ i_a² + i_b² + i_c² dt of the step so far [A²·s]
  std::int64_t elapsed_ns_{0};  ///< of the step so far [ns]
  T temperature_;
  bool was_measured_{false};
};

}  // namespace sextant
