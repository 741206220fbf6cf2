#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sextant/core/description.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/plant_inputs.hpp"

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
  link_sag,          ///< the voltage of the stiff link or of a source falls; not of a sensor
  contactor_open,    ///< the main contactor behind a pre-charge does not close, or opens; not of a sensor
  contactor_welded   ///< it is closed from the beginning on; not of a sensor
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
           kind == PlantFaultKind::link_sag || is_of_contactor();
  }
  [[nodiscard]] bool is_of_contactor() const noexcept {
    return kind == PlantFaultKind::contactor_open || kind == PlantFaultKind::contactor_welded;
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

  /// What holds the main contactor at t_ns.
  [[nodiscard]] Contactor contactor(std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    const PlantFaultKind now = kind_at(t_ns);
    if (now == PlantFaultKind::contactor_open) return Contactor::held_open;
    return now == PlantFaultKind::contactor_welded ? Contactor::welded : Contactor::automatic;
  }

  /// Voltage at t_ns of a link of u_dc. [V]
  [[nodiscard]] double link_voltage(double u_dc, std::int64_t t_ns) const noexcept SEXTANT_NONBLOCKING {
    if (kind_at(t_ns) != PlantFaultKind::link_sag) return u_dc;
    const std::int64_t since_ns = std::max<std::int64_t>(0, t_ns - at_ns);
    if (since_ns >= ramp_ns) return sag_voltage;
    return u_dc + (sag_voltage - u_dc) * (double(since_ns) / double(ramp_ns));
  }
};

/// The kind that is there from power-up on only, as a file names it.
inline constexpr const char* power_up_fault = "cables_swapped";

inline constexpr Choice<PlantFaultKind> plant_fault_kinds[]{
    {"none", PlantFaultKind::none},
    {"current_stuck", PlantFaultKind::current_stuck},
    {"current_zero", PlantFaultKind::current_zero},
    {"current_drift", PlantFaultKind::current_drift},
    {"phases_swapped", PlantFaultKind::phases_swapped},
    {power_up_fault, PlantFaultKind::cables_swapped},
    {"open_phase", PlantFaultKind::open_phase},
    {"speed_lost", PlantFaultKind::speed_lost},
    {"speed_frozen", PlantFaultKind::speed_frozen},
    {"speed_jump", PlantFaultKind::speed_jump},
    {"encoder_reversed", PlantFaultKind::encoder_reversed},
    {"link_stuck", PlantFaultKind::link_stuck},
    {"link_sag", PlantFaultKind::link_sag},
    {"contactor_open", PlantFaultKind::contactor_open},
    {"contactor_welded", PlantFaultKind::contactor_welded}};

/// u_dc: of the link without a fault [V], read before.
inline void describe(Description& d, PlantFaultParameters& p, const double& u_dc) {
  auto& [kind, phase, at_ns, until_ns, drift, jump, sag_voltage, ramp_ns] = p;
  d.choice("kind", kind, plant_fault_kinds,
           "a sensor's, except for those of the motor cables, of the main contactor behind "
           "plant.link.precharge_ohm, and the sag of the link itself, or of its source where it has a "
           "capacitance");
  d.choice("phase", phase, {{"a", 0}, {"b", 1}, {"c", 2}},
           "of a fault of one phase; where two are swapped: it and the next one");
  d.time("at_s", at_ns,
         in_s(0, 1e6,
              "beginning of the fault: in a file as the load's profiles count, 0 from power-up on; in a "
              "request to a running plant from the request on"));
  d.number("until_s", NumberMember::unless_last(until_ns, 1e9),
           {"s", 0, 1e6, "end of the fault, counted as at_s is; not set: it stays"});
  d.number("drift_a_s", drift, {"A/s", -1e6, 1e6, "slope of current_drift"});
  d.number("jump_rad_s", jump, {"rad/s", -1e4, 1e4, "of speed_jump"});
  d.defaulted("sag_v", sag_voltage, {sag_voltage, u_dc, 0.5},
              {"V", 0.5, 2e4, "voltage of link or source to which link_sag leads"},
              Description::no_usable_value);
  d.time("ramp_ms", ramp_ns, in_ms(0, 1e6, "time in which it does so; 0: at once"));
}

}  // namespace sextant
