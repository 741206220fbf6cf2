#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// The records of a link, in shared memory and in datagrams: fixed-width members without padding, least
/// significant byte first. A change of anything below is a new `link_layout_version`.
inline constexpr std::uint32_t link_layout_version = 1;
static_assert(std::endian::native == std::endian::little, "the records of the link are little-endian");

/// A gate pattern. A leg's bits: upper switch on at bit n, leg off at bit n + 3, n = 0…2 for a…c.
struct PatternRecord {
  std::array<std::int32_t, GatePattern::capacity> duration_ns{};  ///< [ns]
  std::array<std::uint8_t, GatePattern::capacity> legs{};
  std::uint32_t count{};  ///< segments in use [-]
  std::uint32_t reserved{};
};

/// Plant → drive, one a plant period.
struct MeasurementRecord {
  std::uint64_t sequence{};  ///< of this plant, from 1, without gaps [-]
  std::int64_t t_ns{};       ///< the instant of the measurement, on the plant's clock [ns]
  double i_a{};              ///< phase currents, positive into the machine [A]
  double i_b{};
  double i_c{};
  double u_dc{};                   ///< DC-link voltage [V]
  double omega_m{};                ///< mechanical speed [rad/s]
  PatternRecord applied{};         ///< the pattern that was applied over the plant period that ends at t_ns
  std::uint64_t pattern_number{};  ///< the newest pattern that the plant had received [-]
  std::uint32_t generation{};      ///< number of the plant's start [-]
  std::uint32_t plausible{};       ///< 0: not valid
};

/// Drive → plant, one a control period.
struct DrivePatternRecord {
  std::uint64_t sequence{};    ///< of this start of the drive, without gaps [-]
  std::int64_t t_ns{};         ///< beginning of the control period, on the drive's clock [ns]
  PatternRecord pattern{};     ///< of the coming period
  std::uint32_t generation{};  ///< number of the drive's start [-]
  std::uint32_t has_pattern{};
};

static_assert(sizeof(PatternRecord) == 48 && std::is_trivially_copyable_v<PatternRecord>);
static_assert(sizeof(MeasurementRecord) == 120 && std::is_trivially_copyable_v<MeasurementRecord>);
static_assert(sizeof(DrivePatternRecord) == 72 && std::is_trivially_copyable_v<DrivePatternRecord>);
static_assert(offsetof(MeasurementRecord, applied) == 56 && offsetof(MeasurementRecord, plausible) == 116);
static_assert(offsetof(DrivePatternRecord, pattern) == 16 && offsetof(DrivePatternRecord, has_pattern) == 68);

[[nodiscard]] inline PatternRecord to_record(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING {
  PatternRecord r;
  for (const GateSegment& segment : pattern.segments()) {
    r.duration_ns[r.count] = segment.duration_ns;
    r.legs[r.count] = std::uint8_t(segment.state.upper_switches() | segment.state.legs_off() << 3U);
    ++r.count;
  }
  return r;
}

/// False, and `pattern` empty, when the record holds no valid pattern.
[[nodiscard]] inline bool to_pattern(const PatternRecord& r,
                                     GatePattern& pattern) noexcept SEXTANT_NONBLOCKING {
  const auto leg = [](unsigned bits, unsigned n) {
    if ((bits >> (n + 3U) & 1U) != 0U) return LegState::off;
    return (bits >> n & 1U) != 0U ? LegState::high : LegState::low;
  };
  pattern = {};
  if (r.count > GatePattern::capacity) return false;
  GatePattern read;
  for (std::uint32_t i = 0; i < r.count; ++i) {
    const unsigned bits = r.legs[i];
    const bool off_and_on = (bits >> 3U & bits) != 0U;
    if (bits > 63U || off_and_on || r.duration_ns[i] < 0) return false;
    read.append({SwitchState{leg(bits, 0), leg(bits, 1), leg(bits, 2)}, r.duration_ns[i]});
  }
  pattern = read;
  return true;
}

[[nodiscard]] inline MeasurementRecord to_record(std::int64_t t_ns,
                                                 const Measurement<double>& m) noexcept SEXTANT_NONBLOCKING {
  MeasurementRecord r;
  r.t_ns = t_ns;
  r.i_a = m.i_abc.a;
  r.i_b = m.i_abc.b;
  r.i_c = m.i_abc.c;
  r.u_dc = m.u_dc;
  r.omega_m = m.omega_m;
  r.applied = to_record(m.applied);
  r.plausible = m.plausible ? 1U : 0U;
  return r;
}

/// True when no segment drives a leg: only diodes conduct.
[[nodiscard]] inline bool all_gates_off(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING {
  for (const GateSegment& segment : pattern.segments()) {
    if (segment.state != gates_off) return false;
  }
  return true;
}

}  // namespace sextant
