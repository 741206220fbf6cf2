#pragma once

#include <array>
#include <cstdint>

#include "sextant/core/drive_request.hpp"

namespace sextant::golden {

/// What the vehicle sends from an instant on, a frame every 10 ms.
struct Order {
  int from_ms{};
  bool enable{false};
  float torque{0};  ///< [N·m]
  bool fault_reset{false};
};

/// The vehicle of a golden run: start, torque steps, two faults each with its reset, and silence until the
/// command counts as lost.
inline constexpr std::array<Order, 14> orders{{
    {.from_ms = 0},
    {.from_ms = 10, .enable = true, .torque = 15},
    {.from_ms = 80, .enable = true, .torque = 40},
    {.from_ms = 90, .enable = true, .torque = -20},
    {.from_ms = 110, .enable = true, .torque = 0},
    {.from_ms = 120, .enable = true, .torque = 25},
    {.from_ms = 140, .fault_reset = true},
    {.from_ms = 150},
    {.from_ms = 160, .enable = true, .torque = 20},
    {.from_ms = 180, .enable = true, .torque = 200},  // above the limit: blocked, 20 N·m hold
    {.from_ms = 190, .enable = true, .torque = 30},
    {.from_ms = 220, .fault_reset = true},
    {.from_ms = 230},
    {.from_ms = 240, .enable = true, .torque = 15},
}};
inline constexpr int last_frame_ms = 280;  // then silence
inline constexpr int end_ms = 500;

inline constexpr int watchdog_ms = 130;    // a fault from outside, in one period
inline constexpr int bad_sensor_ms = 210;  // phase a is no number, in one period

/// Periods that the drive sleeps through, after the instant.
struct Late {
  int at_ms{};
  int periods{};
};
inline constexpr std::array<Late, 2> late{{{172, 3}, {200, 40}}};

/// The request of the period at t_ns.
[[nodiscard]] inline DriveRequest<float> request_at(std::int64_t t_ns) noexcept {
  constexpr std::int64_t frame_ns = 10'000'000;
  const std::int64_t frame =
      (t_ns < last_frame_ms * 1'000'000LL ? t_ns : last_frame_ms * 1'000'000LL) / frame_ns;
  Order order;
  for (const Order& o : orders) {
    if (o.from_ms * 1'000'000LL <= frame * frame_ns) order = o;
  }
  DriveRequest<float> request;
  request.command = {.torque = order.torque,
                     .torque_limit = 250.0F,
                     .enable = order.enable,
                     .fault_reset = order.fault_reset,
                     .received_ns = frame * frame_ns,
                     .sequence = std::uint64_t(frame + 1),
                     .counter = std::uint8_t(frame % 15),
                     .e2e = E2eState::valid};
  if (t_ns == watchdog_ms * 1'000'000LL) request.external.set(Fault::watchdog);
  return request;
}

}  // namespace sextant::golden
