#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "sextant/control/threshold.hpp"
#include "sextant/core/description.hpp"

namespace sextant {

/// Interpretation of the paper's equations 2 to 4.
enum class ComparatorReading : std::uint8_t {
  relay,      ///< two relays with memory: on beyond the band, off at zero error; the ripple is one band
  memoryless  ///< the equations to the letter: on exactly while the error is beyond the band
};

/// Three-level torque comparator made of two relays (paper, 2.2.2, eq. 1–4).
///   error = T_ref − T_est;  output +1: raise torque, −1: lower torque, 0: hold.
/// Upper relay: on when error > upper_band; lower relay: on when error < −lower_band. On the band's edge,
/// for which the equations define no output, the output holds.
template <class T = double>
class TorqueComparator {
 public:
  struct Parameters {
    T upper_band{T(0.918)};  ///< HB of the upper relay [N·m]
    T lower_band{T(0.918)};  ///< HB of the lower relay, as a magnitude [N·m]
    ComparatorReading reading{ComparatorReading::relay};

    friend void describe(Description& d, Parameters& p, const Parameters& by_default) {
      auto& [band_upper, band_lower, how] = p;
      d.defaulted("torque_band_upper_nm", band_upper, by_default.upper_band,
                  {"N·m", 1e-3, 1e5,
                   "torque below its reference beyond which the upper relay raises it, in proportion to flux "
                   "reference and link voltage: this one at flux_reference_wb and plant.u_dc_v; the larger, "
                   "the more ripple and the less switching",
                   Changes::always});
      d.defaulted("torque_band_lower_nm", band_lower, by_default.lower_band,
                  {"N·m", 1e-3, 1e5,
                   "torque above its reference beyond which the lower relay lowers it, in the same "
                   "proportion",
                   Changes::always});
      d.choice("comparator_reading", how,
               {{"relay", ComparatorReading::relay}, {"memoryless", ComparatorReading::memoryless}},
               "torque relays that stay on until the error is zero, or only while it is beyond the band");
    }

    [[nodiscard]] const char* validate() const noexcept {
      if (!(std::isfinite(upper_band) && upper_band > T(0)))
        return "the upper torque band must be above zero";
      if (!(std::isfinite(lower_band) && lower_band > T(0)))
        return "the lower torque band must be above zero";
      return nullptr;
    }
  };

  constexpr explicit TorqueComparator(const Parameters& p) noexcept {
    const bool relay = p.reading == ComparatorReading::relay;
    thresholds_[0].above = relay ? T(0) : -p.lower_band;
    thresholds_[1] = {p.upper_band, -p.lower_band};
    thresholds_[2].below = relay ? T(0) : p.upper_band;
  }

  /// Updates the output by the torque error [N·m]; returns it: +1, 0 or −1.
  constexpr int step(T error) noexcept {
    settle(*this, error);
    return output();
  }

  [[nodiscard]] constexpr int output() const noexcept { return int(level_) - 1; }

  /// Torque errors [N·m] at which the present output changes.
  [[nodiscard]] constexpr Thresholds<T> thresholds() const noexcept { return thresholds_[level_]; }

  /// Changes the output after threshold `i` of `thresholds()` was crossed.
  constexpr void on_crossing(int i) noexcept {
    if (level_ != hold) {
      level_ = hold;
    } else {
      level_ = i == 0 ? raise : lower;
    }
  }

  constexpr void reset() noexcept { level_ = hold; }
  /// Takes the bands of another one; the output stays until the next step.
  constexpr void take_parameters(const TorqueComparator& from) noexcept { thresholds_ = from.thresholds_; }

 private:
  static constexpr std::size_t lower = 0;
  static constexpr std::size_t hold = 1;
  static constexpr std::size_t raise = 2;

  std::array<Thresholds<T>, 3> thresholds_{};  ///< by level
  std::size_t level_{hold};                    ///< the output + 1
};

}  // namespace sextant
