#pragma once

#include <bit>
#include <cstdint>
#include <type_traits>

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

  /// Every member of a control period's telemetry, and every segment of its pattern. A member that is added
  /// to `Telemetry` and not named here does not compile.
  constexpr void add(const Telemetry<double>& x) noexcept {
    const auto& [t_ns, i_abc, u_dc, omega_m, i_dc, psi_s, psi_s_magnitude, torque, r_s, r_r, l_m,
                 r_s_deviation, r_r_deviation, l_m_deviation, torque_monitored, torque_requested,
                 torque_reference, torque_reached, torque_motoring, torque_regenerating, winding_temperature,
                 active, latched, fault_total, first_fault, pattern, unchecked_periods, command_received_ns,
                 command_sequence, command_rejected, command_counter, sector, state, derating_cause,
                 lockout] = x;
    for (const double v : {i_abc.a,
                           i_abc.b,
                           i_abc.c,
                           u_dc,
                           omega_m,
                           i_dc,
                           psi_s.alpha,
                           psi_s.beta,
                           psi_s_magnitude,
                           torque,
                           r_s,
                           r_r,
                           l_m,
                           r_s_deviation,
                           r_r_deviation,
                           l_m_deviation,
                           torque_monitored,
                           torque_requested,
                           torque_reference,
                           torque_reached,
                           torque_motoring,
                           torque_regenerating}) {
      add(v);
    }
    if (winding_temperature) add(*winding_temperature);
    for (const std::int64_t v : {t_ns, command_received_ns}) add(v);
    for (const std::uint64_t v :
         {active.bits(), latched.bits(), unchecked_periods, command_sequence, std::uint64_t{fault_total},
          std::uint64_t{command_rejected}, std::uint64_t{command_counter}, std::uint64_t{sector}, code(state),
          code(first_fault), code(derating_cause), bit(lockout, 0)}) {
      add(v);
    }
    add(pattern);
  }

  /// Every segment, and how many they are.
  constexpr void add(const GatePattern& pattern) noexcept {
    add(std::uint64_t{pattern.segments().size()});
    for (const auto& [state, duration_ns] : pattern.segments()) {
      add(std::uint64_t{state.code()});
      add(std::int64_t{duration_ns});
    }
  }

  [[nodiscard]] constexpr std::uint64_t value() const noexcept { return value_; }

 private:
  template <class Enumeration>
  [[nodiscard]] static constexpr std::uint64_t code(Enumeration x) noexcept {
    return static_cast<std::underlying_type_t<Enumeration>>(x);
  }
  [[nodiscard]] static constexpr std::uint64_t bit(bool b, unsigned place) noexcept {
    return std::uint64_t{b ? 1U : 0U} << place;
  }

  std::uint64_t value_{0};
};

}  // namespace sextant
