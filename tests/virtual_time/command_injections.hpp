#pragma once

#include <cstdint>
#include <vector>

#include "comms/command_frames.hpp"
#include "virtual_time/injection.hpp"

namespace sextant::test {

inline Injection command_silent() {
  return {.name = "command silent",
          .fault = Fault::command_lost,
          .observable = "no command for 200 ms",
          .bound_ns = period,
          .prepare =
              [](CampaignCase& c) {
                const std::int64_t lasts_ns = c.just_inside ? 170 * ms : 300 * ms;
                c.rig.bus.push_back(
                    {.kind = BusEventKind::lose, .begin_ns = c.at_ns, .end_ns = c.at_ns + lasts_ns});
              },
          .make_shows = always([](VirtualRig&, const Telemetry<double>& t) {
            return t.t_ns - t.command_received_ns > 200 * ms;
          }),
          .lasts_ns = 300 * ms};
}

inline Injection command_corrupt() {
  return {.name = "command corrupt",
          .fault = Fault::command_invalid,
          .observable = "E2E state INVALID",
          .bound_ns = 10 * ms,
          .prepare =
              [](CampaignCase& c) {
                c.rig.bus.push_back({.kind = BusEventKind::corrupt,
                                     .begin_ns = c.at_ns,
                                     .end_ns = c.at_ns + 100 * ms,
                                     .count = c.just_inside ? 2U : 0U,
                                     .byte = 3,
                                     .mask = std::uint8_t(c.between(1, 255))});
              },
          .make_shows = always([](VirtualRig& rig, const Telemetry<double>&) {
            return rig.ecu.receiver().command().e2e == E2eState::invalid;
          })};
}

inline Injection command_out_of_range() {
  return {.name = "command out of range",
          .fault = Fault::command_out_of_range,
          .observable = "at once; the third frame comes within 30 ms, the wake-up within 1 ms more",
          .bound_ns = 31 * ms,
          .inject = [](VirtualRig& rig, const CampaignCase& c) {
            rig.torque = 200.0;
            if (!c.just_inside) return;
            rig.run_for(20 * ms);  // two frames
            rig.torque = c.rig.torque;
          }};
}

/// Just inside: each of the first one's frames comes twice.
inline Injection second_vcu() {
  return {.name = "second VCU",
          .fault = Fault::second_master,
          .bound_ns = 50 * ms,
          .prepare =
              [](CampaignCase& c) {
                if (c.just_inside) {
                  c.rig.bus.push_back({.kind = BusEventKind::duplicate,
                                       .begin_ns = c.at_ns,
                                       .end_ns = c.at_ns + 100 * ms,
                                       .delay_ns = 3 * ms});
                  return;
                }
                auto counter = std::uint8_t(c.between(0, 14));
                for (std::int64_t t = c.at_ns; t < c.at_ns + 100 * ms; t += 10 * ms) {
                  c.rig.bus.push_back({.kind = BusEventKind::insert,
                                       .begin_ns = t,
                                       .frame = testing::command_frame(counter, c.rig.torque + 1.0)});
                  counter = std::uint8_t((counter + 1) % 15);
                }
              },
          .lasts_ns = 150 * ms};
}

/// Just inside: a controller that reports errors, but is not off the bus.
inline Injection bus_off() {
  return {.name = "bus-off", .fault = Fault::bus_off, .bound_ns = 10 * ms, .prepare = [](CampaignCase& c) {
            if (c.just_inside) {
              c.rig.bus.push_back({.kind = BusEventKind::insert,
                                   .begin_ns = c.at_ns,
                                   .frame = {.id = ~can_error_bus_off & 0x1FFU, .error = true, .length = 8}});
            } else {
              c.rig.bus.push_back(
                  {.kind = BusEventKind::bus_off, .begin_ns = c.at_ns, .end_ns = c.at_ns + 100 * ms});
            }
          }};
}

inline Injection status_not_sent() {
  return {
      .name = "status not sent",
      .fault = Fault::transmit_lost,
      .bound_ns = 300 * ms + period,
      .prepare =
          [](CampaignCase& c) {
            const std::int64_t lasts_ns = c.just_inside ? 280 * ms : 400 * ms;
            c.rig.bus.push_back(
                {.kind = BusEventKind::refuse_transmit, .begin_ns = c.at_ns, .end_ns = c.at_ns + lasts_ns});
          },
      .lasts_ns = 500 * ms};
}

inline Injection overruns() {
  return {.name = "three overruns in a row",
          .fault = Fault::overrun,
          .observable = "third overrun",
          .bound_ns = period,
          .prepare =
              [](CampaignCase& c) {
                const LateWake late{c.at_ns, c.wake_ns() * c.between(1, 10)};
                c.rig.late_wakes.assign(c.just_inside ? 2 : 3, late);
              },
          .make_shows = always([](VirtualRig& rig, const Telemetry<double>&) {
            return rig.ecu.wakes().overruns_in_a_row >= 3;
          })};
}

inline Injection control_thread_stalled() {
  return {.name = "control thread stalled",
          .fault = Fault::watchdog,
          .observable = "the wake-up after it",
          .bound_ns = period,
          .prepare =
              [](CampaignCase& c) {
                const std::int64_t stall_ns =
                    c.just_inside ? c.between(30, 45) * ms : c.between(101, 180) * ms;
                c.rig.late_wakes = {{c.at_ns, stall_ns}};
              },
          .make_shows =
              always([](VirtualRig& rig, const Telemetry<double>&) { return rig.ecu.wakes().overruns > 0; }),
          .lasts_ns = 250 * ms};
}

/// Of the vehicle, the bus and the drive's own threads.
inline std::vector<Injection> command_injections() {
  return {command_silent(),  command_corrupt(), command_out_of_range(),  second_vcu(), bus_off(),
          status_not_sent(), overruns(),        control_thread_stalled()};
}

}  // namespace sextant::test
