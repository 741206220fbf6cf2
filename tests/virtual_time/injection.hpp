#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "virtual_time/campaign_case.hpp"

namespace sextant::test {

/// Speed of the shaft and torque of the command.
struct OperatingPoint {
  double omega_m{};  ///< [rad/s]
  double torque{};   ///< [N·m]
};

using OperatingPoints = std::array<OperatingPoint, 3>;

inline constexpr OperatingPoints usual_points{{{0.0, 15.0}, {40.0, 60.0}, {-80.0, -15.0}}};
/// Fast enough for the speed by voltages and currents.
inline constexpr OperatingPoints turning_points{{{60.0, 60.0}, {100.0, 15.0}, {-80.0, -15.0}}};

/// One way to provoke a fault in the whole live drive, and how soon the drive must be in FAULT.
struct Injection {
  /// Changes the case before the drive is made.
  using Prepare = std::function<void(CampaignCase&)>;
  /// Brings the cause about in the running drive at `at_ns` of the case.
  using Inject = std::function<void(VirtualRig&, const CampaignCase&)>;
  /// Whether the cause is observable in this period.
  using Shows = std::function<bool(VirtualRig&, const Telemetry<double>&)>;

  std::string name;
  Fault fault{};                      ///< that is to be raised
  std::string observable{"at once"};  ///< what `shows` says, in words
  std::int64_t bound_ns{};            ///< from the period in which it becomes observable to FAULT [ns]
  Prepare prepare{};
  Inject inject{};
  std::function<Shows()> make_shows{};  ///< of one run; empty: observable at once
  std::int64_t lasts_ns{100 * ms};      ///< from `at_ns`, until the cause is gone [ns]
  OperatingPoints points{usual_points};
  std::vector<Fault> also{};  ///< other names of the same cause
  bool must_last{false};      ///< only a cause that shows without a break, up to FAULT, counts
  bool has_inside{true};      ///< `just_inside` of the case makes a cause that is no fault
};

inline constexpr std::int64_t period = VirtualRig::period_ns;

/// The first control period at or after t_ns.
constexpr std::int64_t on_grid(std::int64_t t_ns) {
  return (t_ns + period - 1) / period * period;
}

/// Largest magnitude of a phase.
inline double largest(const ThreePhase<double>& i) {
  return std::max({std::abs(i.a), std::abs(i.b), std::abs(i.c)});
}

/// Of a cause whose `shows` needs the plant: each period is a wake-up, so that the plant is that of the
/// period.
inline void wake_in_every_period(CampaignCase& c) {
  c.rig.wake_every_periods = 1;
}

inline double random_sign(CampaignCase& c) {
  return c.between(0, 1) == 0 ? -1.0 : 1.0;
}

/// A fault of the plant or of its sensors in a random phase.
inline void set_plant_fault(CampaignCase& c, PlantFaultKind kind, std::int64_t lasts_ns) {
  wake_in_every_period(c);
  c.rig.fault.kind = kind;
  c.rig.fault.phase = int(c.between(0, 2));
  c.rig.fault.at_ns = c.at_ns;
  c.rig.fault.until_ns = c.at_ns + lasts_ns;
}

/// That fault from `at_ns` of the case on, named `fault` by the drive; nothing like it is just inside a
/// limit.
inline Injection plant_fault(const std::string& name, PlantFaultKind kind, Fault fault, std::int64_t bound_ns,
                             std::int64_t lasts_ns = 100 * ms) {
  return {.name = name,
          .fault = fault,
          .bound_ns = bound_ns,
          .prepare = [kind, lasts_ns](CampaignCase& c) { set_plant_fault(c, kind, lasts_ns); },
          .lasts_ns = lasts_ns,
          .has_inside = false};
}

/// A measurement that is wrong from the first period after `at_ns` on.
inline void add_event(CampaignCase& c, std::int64_t lasts_ns, MeasurementEvent event) {
  event.begin_ns = on_grid(c.at_ns);
  event.end_ns = event.begin_ns + lasts_ns;
  c.rig.measurements.push_back(event);
}

/// The speed goes to `to` and back.
inline void ramp_speed(CampaignCase& c, double to, std::int64_t takes_ns, std::int64_t holds_ns) {
  const double from = c.rig.omega_m;
  const double t0 = double(c.at_ns) * 1e-9;
  const double takes = double(takes_ns) * 1e-9;
  const double holds = double(holds_ns) * 1e-9;
  c.rig.speed = ProfileParameters{.shape = ProfileShape::linear,
                                  .points = {{0.0, from},
                                             {t0, from},
                                             {t0 + takes, to},
                                             {t0 + takes + holds, to},
                                             {t0 + 2.0 * takes + holds, from}}};
}

/// A predicate that needs no memory.
inline std::function<Injection::Shows()> always(Injection::Shows shows) {
  return [shows = std::move(shows)] { return shows; };
}

}  // namespace sextant::test
