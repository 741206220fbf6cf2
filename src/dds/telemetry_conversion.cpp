#include "telemetry_conversion.hpp"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>

namespace sextant {
namespace {

#define SEXTANT_SAME_VALUE(type, enumerator, of_contract) \
  static_assert(int{sextant_##of_contract} == int(type::enumerator));
SEXTANT_DRIVE_STATES(SEXTANT_SAME_VALUE)
SEXTANT_WAIT_MODES(SEXTANT_SAME_VALUE)
SEXTANT_SCHEDULING_POLICIES(SEXTANT_SAME_VALUE)
#undef SEXTANT_SAME_VALUE

// A member of a record to that of the generated type. False where the value is NaN or infinite.

template <std::floating_point Out>
bool assign(double in, Out& out) noexcept {
  out = static_cast<Out>(in);
  return std::isfinite(out);
}

template <std::integral Value>
bool assign(const Value& in, Value& out) noexcept {
  out = in;
  return true;
}

template <class Enum, class Kind>
  requires(std::is_enum_v<Enum> && std::is_enum_v<Kind>)
bool assign(Enum in, Kind& out) noexcept {
  out = static_cast<Kind>(in);
  return true;
}

bool assign(FaultSet in, std::uint64_t& out) noexcept {
  out = in.bits();
  return true;
}

bool assign(std::optional<Fault> in, std::int32_t& out) noexcept {
  out = in ? int(*in) : -1;
  return true;
}

/// Copies as much as fits, never cutting a UTF-8 character, and terminates.
template <std::size_t size>
bool assign(std::string_view in, char (&out)[size]) noexcept {
  std::size_t n = std::min(in.size(), size - 1);
  const auto continues = [&](std::size_t i) { return (static_cast<unsigned char>(in[i]) & 0xC0U) == 0x80U; };
  while (n > 0 && n < in.size() && continues(n)) --n;
  std::fill(std::copy_n(in.begin(), n, out), out + size, '\0');
  return true;
}

/// Refers to the values, which DDS reads only. Values that are not finite are what a waveform has to show.
template <class T, std::size_t most, class Sequence>
bool assign(const BoundedSequence<T, most>& in, Sequence& out) noexcept {
  out._maximum = most;
  out._length = std::uint32_t(in.size());
  out._buffer = const_cast<T*>(in.values().data());
  out._release = false;
  return true;
}

}  // namespace

#define SEXTANT_ASSIGN(member, unit, text) finite = assign(in.member, out.member) && finite;

bool convert(const TelemetryIntervalRecord<double>& in, std::uint64_t dropped,
             sextant_DriveTelemetry& out) noexcept {
  bool finite = true;
  SEXTANT_TELEMETRY_MEMBERS(SEXTANT_ASSIGN)
  out.dropped = static_cast<std::uint32_t>(std::min<std::uint64_t>(dropped, UINT32_MAX));
  return finite;
}

bool convert(const DriveStateSample& in, sextant_DriveState& out) noexcept {
  bool finite = true;
  SEXTANT_DRIVE_STATE_MEMBERS(SEXTANT_ASSIGN)
  return finite;
}

bool convert(const RealTimeSample& in, sextant_RealTimeStatistics& out) noexcept {
  bool finite = true;
  SEXTANT_REAL_TIME_MEMBERS(SEXTANT_ASSIGN)
  return finite;
}

bool convert(const WaveformBatch& in, std::uint64_t dropped, sextant_DriveWaveform& out) noexcept {
  bool finite = true;
  SEXTANT_WAVEFORM_MEMBERS(SEXTANT_ASSIGN)
  out.dropped = dropped;
  return finite;
}

#undef SEXTANT_ASSIGN

}  // namespace sextant
