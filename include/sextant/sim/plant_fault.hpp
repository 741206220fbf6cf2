#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// Faults that a simulated power stage can be given, in its sensors unless said otherwise.
enum class PlantFaultKind : std::uint8_t {
  none,
  current_stuck,     ///< the current of the phase keeps its last reading
  current_zero,      ///< it reads zero
  current_drift,     ///< its offset rises
  phases_swapped,    ///< the current of the phase is read as that of the next one, and the reverse
  cables_swapped,    ///< the motor cables of the phase and the next one are exchanged; not of a sensor
  open_phase,        ///< the motor cable of the phase opens; not of a sensor
  speed_lost,        ///< the speed reads zero, a measured angle keeps its last reading
  speed_frozen,      ///< speed and angle keep their last reading
  speed_jump,        ///< the speed jumps and stays beside the true one
  encoder_reversed,  ///< speed and angle read with the other sign
  link_stuck,        ///< the link voltage keeps its last reading
  link_sag           ///< the voltage of the stiff link or of a source falls; not of a sensor
};

/// One fault, and the time for which it is there. Times count as the profiles of the load do; one that begins
/// at zero is there from power-up on, also in the hand-shake before.
struct PlantFaultParameters {
  static constexpr std::int64_t never_ns = std::numeric_limits<std::int64_t>::max();

  PlantFaultKind kind{PlantFaultKind::none};
  int phase{};                      ///< 0, 1 or 2: a, b or c, of a fault of one phase [-]
  std::int64_t at_ns{};             ///< its beginning [ns]
  std::int64_t until_ns{never_ns};  ///< its end [ns]
  double drift{1.0};                ///< slope of `current_drift` [A/s]
  double jump{10.0};                ///< of `speed_jump` [rad/s]
  double sag_voltage{265.0};        ///< to which `link_sag` leads [V]
  std::int64_t ramp_ns{};           ///< time in which it does so; 0: at once [ns]

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    if (phase < 0 || phase > 2) return "the phase must be 0, 1 or 2";
    if (until_ns <= at_ns) return "the fault must end after it began";
    if (!std::isfinite(drift)) return "the drift must be finite";
    if (!std::isfinite(jump)) return "the jump must be finite";
    if (!(std::isfinite(sag_voltage) && sag_voltage > 0.0)) return "the sag voltage must be above zero";
    if (kind == PlantFaultKind::cables_swapped && (at_ns != 0 || until_ns != never_ns)) {
      return "swapped motor cables must be so from the beginning to the end";
    }
    return ramp_ns >= 0 ? nullptr : "the ramp must not be below zero";
  }

  /// True for a fault that changes more than what a sensor reads.
  [[nodiscard]] bool acts_on_plant() const noexcept {
    return kind == PlantFaultKind::cables_swapped || kind == PlantFaultKind::open_phase ||
           kind == PlantFaultKind::link_sag;
  }

  /// The same with times that count from t_ns.
  [[nodiscard]] PlantFaultParameters since(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    PlantFaultParameters later = *this;
    later.at_ns += t_ns;
    if (until_ns != never_ns) later.until_ns += t_ns;
    return later;
  }

  /// What is there at t_ns.
  [[nodiscard]] PlantFaultKind kind_at(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    return (t_ns >= at_ns || at_ns == 0) && t_ns < until_ns ? kind : PlantFaultKind::none;
  }

  /// The first instant after t_ns at which the fault begins, ends, or its ramp ends. [ns]
  [[nodiscard]] std::int64_t next_corner_ns(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    std::int64_t next = never_ns;
    if (kind == PlantFaultKind::none) return next;
    for (const std::int64_t corner : {at_ns, at_ns + ramp_ns, until_ns}) {
      if (corner > t_ns) next = std::min(next, corner);
    }
    return next;
  }

  /// Voltage at t_ns of a link of u_dc. [V]
  [[nodiscard]] double link_voltage(double u_dc, std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    if (kind_at(t_ns) != PlantFaultKind::link_sag) return u_dc;
    const std::int64_t since_ns = std::max<std::int64_t>(0, t_ns - at_ns);
    if (since_ns >= ramp_ns) return sag_voltage;
    return u_dc + (sag_voltage - u_dc) * (double(since_ns) / double(ramp_ns));
  }
};

}  // namespace sextant
