#pragma once

#include <bit>
#include <cstdint>

#include "sextant/comms/can_frame.hpp"
#include "sextant/core/telemetry.hpp"

namespace sextant {

/// A number of 64 bits by which two sequences are compared bit for bit, order included. Words are
/// mixed in with the constants of splitmix64 (Steele, Lea, Flood: Fast splittable pseudorandom number
/// generators, 2014). It detects differences by chance, not forged ones.
class Digest {
 public:
  constexpr void add(std::uint64_t word) noexcept {
    value_ ^= word;
    value_ += 0x9E3779B97F4A7C15ULL;
    value_ = (value_ ^ (value_ >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    value_ ^= value_ >> 27U;
  }
  constexpr void add(std::int64_t x) noexcept { add(static_cast<std::uint64_t>(x)); }
  /// Bit by bit: 0 and -0 differ, as do two NaNs of different content.
  constexpr void add(double x) noexcept { add(std::bit_cast<std::uint64_t>(x)); }

  /// All of a frame, with the time that the caller gives [ns].
  constexpr void add(const CanFrame& frame, std::int64_t t_ns) noexcept {
    add(t_ns);
    add(std::uint64_t{frame.id} | std::uint64_t{frame.length} << 32U | bit(frame.extended, 40) |
        bit(frame.rtr, 41) | bit(frame.error, 42) | bit(frame.fd, 43));
    std::uint64_t word = 0;
    for (unsigned k = 0; k < frame.length; ++k) {
      word = word << 8U | frame.data[k];
      if (k % 8U == 7U) add(word);
    }
    if (frame.length % 8U != 0) add(word);
  }

  /// Every member of a control period's telemetry.
  constexpr void add(const Telemetry<double>& x) noexcept {
    add(x.t_ns);
    for (const double v : {x.torque_requested, x.torque_reference, x.torque, x.psi_s.alpha, x.psi_s.beta,
                           x.psi_s_magnitude, x.i_abc.a, x.i_abc.b, x.i_abc.c, x.u_dc, x.i_dc, x.omega_m,
                           x.torque_motoring, x.torque_regenerating}) {
      add(v);
    }
    add(x.active.bits() ^ std::rotl(x.latched.bits(), 32));
    add(std::uint64_t{x.fault_total} | std::uint64_t{x.sector} << 32U |
        std::uint64_t{static_cast<std::uint8_t>(x.state)} << 40U |
        std::uint64_t{static_cast<std::uint8_t>(x.first_fault)} << 48U | bit(x.lockout, 56));
    add(x.command_received_ns);
    add(x.command_sequence);
    add(std::uint64_t{x.command_counter} | std::uint64_t{x.pattern.last_state().upper_switches()} << 8U |
        std::uint64_t{x.pattern.last_state().legs_off()} << 16U | std::uint64_t{x.command_rejected} << 32U);
  }

  [[nodiscard]] constexpr std::uint64_t value() const noexcept { return value_; }

 private:
  [[nodiscard]] static constexpr std::uint64_t bit(bool b, unsigned place) noexcept {
    return std::uint64_t{b ? 1U : 0U} << place;
  }

  std::uint64_t value_{0};
};

}  // namespace sextant
