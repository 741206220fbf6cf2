#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "comms/command_frames.hpp"
#include "harness/campaign.hpp"

namespace sextant::test {

/// One way to provoke a fault in the whole live drive, and how soon the gates must be off (F).
struct Injection {
  std::string name;
  Fault fault;            ///< that is to be raised
  std::int64_t bound_ns;  ///< from the first period in which it shows to FAULT [ns]
  /// Changes the case before the drive is made. The cause begins at `at_ns` of the case.
  std::function<void(CampaignCase&)> prepare{};
  /// Brings it about in the running drive, at `at_ns`.
  std::function<void(VirtualRig&, CampaignCase&)> inject{};
  /// Whether it can be seen in this period at all; empty: at once.
  std::function<bool(VirtualRig&, const Telemetry<double>&)> shows{};
  std::int64_t lasts_ns{100 * ms};  ///< [ns]
};

inline constexpr std::int64_t period = VirtualRig::period_ns;

/// The first control period at or after t_ns.
constexpr std::int64_t on_grid(std::int64_t t_ns) {
  return (t_ns + period - 1) / period * period;
}

inline std::array<double, 3> phases(const ThreePhase<double>& i) {
  return {i.a, i.b, i.c};
}

/// Largest difference between what the drive takes a phase current for and what flows. [A]
inline double current_deviation(VirtualRig& rig, const Telemetry<double>& t) {
  const auto read = phases(t.i_abc);
  const auto real = phases(rig.plant().i_abc());
  double worst = 0.0;
  for (std::size_t n = 0; n < 3; ++n) worst = std::max(worst, std::abs(read[n] - real[n]));
  return worst;
}

inline double largest(const ThreePhase<double>& i) {
  return std::max({std::abs(i.a), std::abs(i.b), std::abs(i.c)});
}

/// The limit of the sum, the tolerance of the gains, and what noise and offsets can take away from it.
inline bool sum_shows(VirtualRig& rig, const Telemetry<double>& t) {
  const ProtectionLimits<> limits = rig.drive_parameters().protection;
  const double limit = limits.current_sum + 1.5 * limits.current_gain_tolerance * largest(t.i_abc) + 3.0;
  return current_deviation(rig, t) > limit;
}

inline bool speed_shows(VirtualRig& rig, const Telemetry<double>& t) {
  const double limit = rig.drive_parameters().protection.speed_error;
  return std::abs(t.omega_m - rig.plant().omega_m()) > limit + 6.0;
}

/// Each period is a wake-up, so that the plant is that of the period.
inline void wake_in_every_period(CampaignCase& c) {
  c.rig.wake_every_periods = 1;
}

/// Fast enough for the speed by voltages and currents, both ways.
inline void turn(CampaignCase& c) {
  wake_in_every_period(c);
  constexpr std::array speeds{-100.0, -80.0, -60.0, 60.0, 80.0, 100.0};
  c.rig.omega_m = speeds[std::size_t(c.between(0, 5))];
}

inline std::function<void(CampaignCase&)> plant_fault(PlantFaultKind kind, std::int64_t lasts_ns) {
  return [kind, lasts_ns](CampaignCase& c) {
    wake_in_every_period(c);
    c.rig.fault.kind = kind;
    c.rig.fault.phase = int(c.between(0, 2));
    c.rig.fault.at_ns = c.at_ns;
    c.rig.fault.until_ns = c.at_ns + lasts_ns;
  };
}

inline void ramp_speed(CampaignCase& c, double from, double to, std::int64_t takes_ns,
                       std::int64_t holds_ns) {
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

inline void add_event(VirtualRig& rig, const CampaignCase& c, std::int64_t lasts_ns, MeasurementEvent event) {
  event.begin_ns = on_grid(c.at_ns);
  event.end_ns = event.begin_ns + lasts_ns;
  rig.io.add(event);
}

/// Every fault of the contract at least once, and each of the sensors' faults.
inline std::vector<Injection> fault_injections() {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Injection> list;
  list.push_back({.name = "command silent",
                  .fault = Fault::command_lost,
                  .bound_ns = 210 * ms + period,
                  .inject = [](VirtualRig& rig, CampaignCase&) { rig.vehicle.pause_sending(true); },
                  .lasts_ns = 300 * ms});
  list.push_back({.name = "command corrupt",
                  .fault = Fault::command_invalid,
                  .bound_ns = 40 * ms,
                  .inject = [](VirtualRig& rig, CampaignCase& c) {
                    rig.bus.add({.kind = BusEventKind::corrupt,
                                 .begin_ns = c.at_ns,
                                 .end_ns = c.at_ns + 100 * ms,
                                 .byte = 3,
                                 .mask = std::uint8_t(c.between(1, 255))});
                  }});
  list.push_back({.name = "command out of range",
                  .fault = Fault::command_out_of_range,
                  .bound_ns = 40 * ms,
                  .inject = [](VirtualRig& rig, CampaignCase&) { rig.torque = 200.0; }});
  list.push_back({.name = "second VCU",
                  .fault = Fault::second_master,
                  .bound_ns = 50 * ms,
                  .inject =
                      [](VirtualRig& rig, CampaignCase& c) {
                        auto counter = std::uint8_t(c.between(0, 14));
                        for (std::int64_t t = c.at_ns; t < c.at_ns + 100 * ms; t += 10 * ms) {
                          rig.bus.add({.kind = BusEventKind::insert,
                                       .begin_ns = t,
                                       .frame = testing::command_frame(counter, c.rig.torque + 1.0)});
                          counter = std::uint8_t((counter + 1) % 15);
                        }
                      },
                  .lasts_ns = 150 * ms});
  list.push_back({.name = "bus-off",
                  .fault = Fault::bus_off,
                  .bound_ns = 10 * ms,
                  .inject = [](VirtualRig& rig, CampaignCase& c) {
                    rig.bus.add(
                        {.kind = BusEventKind::bus_off, .begin_ns = c.at_ns, .end_ns = c.at_ns + 100 * ms});
                  }});
  list.push_back({.name = "NaN",
                  .fault = Fault::measurement_invalid,
                  .bound_ns = period,
                  .inject = [](VirtualRig& rig, CampaignCase& c) {
                    add_event(rig, c, period,
                              {.signal = static_cast<MeasuredSignal>(c.between(0, 4)), .offset = nan});
                  }});
  const auto sensor = [&](const char* name, PlantFaultKind kind) {
    list.push_back({.name = name,
                    .fault = Fault::current_sum,
                    .bound_ns = 5 * period,
                    .prepare =
                        [kind](CampaignCase& c) {
                          plant_fault(kind, 200 * ms)(c);
                          c.rig.fault.drift = c.between(0, 1) == 0 ? -1000.0 : 1000.0;
                        },
                    .shows = sum_shows,
                    .lasts_ns = 200 * ms});
  };
  sensor("current sensor stuck", PlantFaultKind::current_stuck);
  sensor("current sensor open", PlantFaultKind::current_zero);
  sensor("current sensor drifts", PlantFaultKind::current_drift);
  list.push_back(
      {.name = "current sensors swapped",
       .fault = Fault::current_sensor,
       .bound_ns = 20 * ms,
       .prepare = plant_fault(PlantFaultKind::phases_swapped, 100 * ms),
       .shows = [](VirtualRig& rig, const Telemetry<double>& t) { return current_deviation(rig, t) > 4.0; }});
  list.push_back(
      {.name = "current converter stopped",
       .fault = Fault::current_sensor,
       .bound_ns = 5 * period,
       .prepare = wake_in_every_period,
       .inject = [](VirtualRig& rig,
                    CampaignCase& c) { add_event(rig, c, 100 * ms, {.holds_currents = true}); },
       .shows = [](VirtualRig& rig, const Telemetry<double>& t) { return current_deviation(rig, t) > 6.0; }});
  list.push_back({.name = "over-current",
                  .fault = Fault::over_current,
                  .bound_ns = period,
                  .inject = [](VirtualRig& rig, CampaignCase& c) {
                    const double limit = rig.drive_parameters().protection.over_current;
                    const double sign = c.between(0, 1) == 0 ? -1.0 : 1.0;
                    add_event(rig, c, period,
                              {.signal = static_cast<MeasuredSignal>(c.between(0, 2)),
                               .offset = sign * (limit + 0.1 * double(c.between(50, 1000)))});
                  }});
  list.push_back({.name = "link over-voltage",
                  .fault = Fault::dc_over_voltage,
                  .bound_ns = period,
                  .inject = [](VirtualRig& rig, CampaignCase& c) {
                    add_event(rig, c, period, {.signal = MeasuredSignal::u_dc, .offset = 701.0});
                  }});
  list.push_back({.name = "link under-voltage",
                  .fault = Fault::dc_under_voltage,
                  .bound_ns = 1 * ms,
                  .prepare =
                      [](CampaignCase& c) {
                        plant_fault(PlantFaultKind::link_sag, 100 * ms)(c);
                        c.rig.fault.sag_voltage = double(c.between(150, 250));
                        c.rig.fault.ramp_ns = c.between(0, 50) * ms;
                      },
                  .shows =
                      [](VirtualRig& rig, const Telemetry<double>& t) {
                        return t.u_dc < rig.drive_parameters().protection.dc_under_voltage;
                      }});
  list.push_back({.name = "speed lost",
                  .fault = Fault::speed_sensor,
                  .bound_ns = 10 * ms,
                  .prepare = [](CampaignCase& c) {
                    turn(c);
                    plant_fault(PlantFaultKind::speed_lost, 100 * ms)(c);
                  }});
  list.push_back({.name = "speed frozen",
                  .fault = Fault::speed_sensor,
                  .bound_ns = 10 * ms,
                  .prepare =
                      [](CampaignCase& c) {
                        turn(c);
                        ramp_speed(c, c.rig.omega_m, 0.25 * c.rig.omega_m, 100 * ms, 100 * ms);
                        plant_fault(PlantFaultKind::speed_frozen, 250 * ms)(c);
                      },
                  .shows = speed_shows,
                  .lasts_ns = 300 * ms});
  list.push_back({.name = "speed jumps",
                  .fault = Fault::speed_sensor,
                  .bound_ns = 10 * ms,
                  .prepare =
                      [](CampaignCase& c) {
                        turn(c);
                        plant_fault(PlantFaultKind::speed_jump, 100 * ms)(c);
                        c.rig.fault.jump = (c.between(0, 1) == 0 ? -1.0 : 1.0) * double(c.between(36, 90));
                      },
                  .shows = speed_shows});
  list.push_back({.name = "over-speed",
                  .fault = Fault::over_speed,
                  .bound_ns = 1 * ms,
                  .prepare =
                      [](CampaignCase& c) {
                        turn(c);
                        const double sign = std::copysign(1.0, c.rig.omega_m);
                        c.rig.drive.protection.over_speed = 110.0;
                        ramp_speed(c, c.rig.omega_m, sign * 120.0, 50 * ms, 50 * ms);
                      },
                  .shows =
                      [](VirtualRig& rig, const Telemetry<double>& t) {
                        return std::abs(t.omega_m) > rig.drive_parameters().protection.over_speed;
                      },
                  .lasts_ns = 200 * ms});
  list.push_back({.name = "winding too hot",
                  .fault = Fault::over_temperature,
                  .bound_ns = 100 * ms,
                  .prepare =
                      [](CampaignCase& c) {
                        // 12 A RMS would heat by 1280 K in the end, and from 40 to 75 °C within half a
                        // second.
                        c.rig.drive.protection.winding = {.nominal_current = 3.0, .time_constant = 15.0};
                        c.rig.drive.protection.winding_warning = 55.0;
                        c.rig.drive.protection.winding_trip = 75.0;
                        c.rig.torque = std::copysign(10.0, c.rig.torque);
                      },
                  .shows = [](VirtualRig&, const Telemetry<double>&) { return false; },
                  .lasts_ns = 2'000 * ms});
  list.push_back({.name = "torque deviates: link voltage reads low",
                  .fault = Fault::torque_plausibility,
                  .bound_ns = 10 * ms,
                  .prepare =
                      [](CampaignCase& c) {
                        turn(c);
                        c.rig.torque = std::copysign(70.0, c.rig.torque);
                      },
                  .inject =
                      [](VirtualRig& rig, CampaignCase& c) {
                        add_event(rig, c, 200 * ms, {.signal = MeasuredSignal::u_dc, .gain = 0.65});
                      },
                  .shows =
                      [](VirtualRig& rig, const Telemetry<double>& t) {
                        return std::abs(rig.plant().tau_e() - t.torque_reference) > 30.0;
                      },
                  .lasts_ns = 200 * ms});
  list.push_back({.name = "open phase",
                  .fault = Fault::open_phase,
                  .bound_ns = 20 * ms,
                  .prepare = plant_fault(PlantFaultKind::open_phase, 100 * ms),
                  .shows = [](VirtualRig& rig, const Telemetry<double>&) {
                    return largest(rig.plant().i_abc()) > 5.0;
                  }});
  list.push_back({.name = "flux lost",
                  .fault = Fault::flux_lost,
                  .bound_ns = 25 * ms,
                  .prepare =
                      [](CampaignCase& c) {
                        // Sectors that begin on the vectors, with the paper's estimator, collapse in reverse
                        // rotation.
                        c.rig.controller.flux_estimator = FluxEstimatorKind::voltage_model;
                        c.rig.controller.flux_priority = false;
                        c.rig.controller.sector.sector_start_deg = 0.0;
                        c.rig.drive.torque_monitor.enabled = false;
                        c.rig.torque = 15.0;
                        ramp_speed(c, 20.0, -60.0, 50 * ms, 300 * ms);
                      },
                  .shows =
                      [](VirtualRig& rig, const Telemetry<double>& t) {
                        const double reference = rig.drive_parameters().capability.flux_reference;
                        return t.psi_s_magnitude < 0.5 * reference;
                      },
                  .lasts_ns = 400 * ms});
  list.push_back({.name = "three overruns in a row",
                  .fault = Fault::overrun,
                  .bound_ns = period,
                  .prepare =
                      [](CampaignCase& c) {
                        const std::int64_t late_ns = c.wake_ns() * c.between(1, 10);
                        c.rig.late_wakes = {{c.at_ns, late_ns}, {c.at_ns, late_ns}, {c.at_ns, late_ns}};
                      },
                  .shows = [](VirtualRig& rig,
                              const Telemetry<double>&) { return rig.ecu.wakes().overruns_in_a_row >= 3; }});
  list.push_back(
      {.name = "control thread stalled",
       .fault = Fault::watchdog,
       .bound_ns = period,
       .prepare = [](CampaignCase& c) { c.rig.late_wakes = {{c.at_ns, c.between(101, 180) * ms}}; },
       .shows = [](VirtualRig& rig, const Telemetry<double>&) { return rig.ecu.wakes().overruns > 0; },
       .lasts_ns = 250 * ms});
  list.push_back({.name = "status not sent",
                  .fault = Fault::transmit_lost,
                  .bound_ns = 300 * ms + period,
                  .inject =
                      [](VirtualRig& rig, CampaignCase& c) {
                        rig.bus.add({.kind = BusEventKind::refuse_transmit,
                                     .begin_ns = c.at_ns,
                                     .end_ns = c.at_ns + 400 * ms});
                      },
                  .lasts_ns = 500 * ms});
  return list;
}

}  // namespace sextant::test
