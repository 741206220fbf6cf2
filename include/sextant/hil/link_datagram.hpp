#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "sextant/core/nonblocking.hpp"
#include "sextant/hil/link_records.hpp"

namespace sextant {

/// "SXHL" as the bytes lie in a datagram.
inline constexpr std::uint32_t datagram_magic = 0x4C485853;

enum class DatagramKind : std::uint16_t { measurement = 1, pattern = 2 };

/// The beginning of each datagram; magic and version stay where they are in every version.
struct DatagramHeader {
  std::uint32_t magic{datagram_magic};
  std::uint16_t version{std::uint16_t{link_layout_version}};
  std::uint16_t kind{};
  std::uint64_t sequence{};    ///< of this sender and kind, without gaps [-]
  std::int64_t sent_ns{};      ///< on the sender's clock [ns]
  std::int64_t period_ns{};    ///< the sender's period [ns]
  std::uint32_t generation{};  ///< which start of the sender this is, at random, never 0 [-]
  std::uint32_t count{};       ///< records that follow [-]
};

/// Plant → drive: the newest measurement and those before it, newest first, so that a lost datagram is made
/// up for by any of the next seven.
struct MeasurementDatagram {
  static constexpr std::size_t capacity = 8;
  DatagramHeader header{};
  std::array<MeasurementRecord, capacity> records{};
};

/// Drive → plant.
struct CommandDatagram {
  DatagramHeader header{};
  DrivePatternRecord command{};
  std::uint32_t gate_enable{};  ///< 1 while the gates may be on
  std::uint32_t leaving{};      ///< 1: the drive announces its end
};

/// Whether the records have the numbers and the start of the header, as those of one sender have.
[[nodiscard]] inline bool is_of_its_header(const MeasurementDatagram& d) noexcept SEXTANT_NONBLOCKING {
  for (std::uint32_t n = 0; n < d.header.count; ++n) {
    const MeasurementRecord& record = d.records[n];
    if (record.sequence != d.header.sequence - n || record.generation != d.header.generation) return false;
  }
  return true;
}
[[nodiscard]] inline bool is_of_its_header(const CommandDatagram& d) noexcept SEXTANT_NONBLOCKING {
  return d.command.sequence == d.header.sequence && d.command.generation == d.header.generation;
}

static_assert(sizeof(DatagramHeader) == 40 && offsetof(DatagramHeader, count) == 36);
static_assert(sizeof(MeasurementDatagram) == 1000 && offsetof(MeasurementDatagram, records) == 40);
static_assert(sizeof(CommandDatagram) == 120 && offsetof(CommandDatagram, gate_enable) == 112);
static_assert(std::is_trivially_copyable_v<MeasurementDatagram> &&
              std::is_trivially_copyable_v<CommandDatagram>);

}  // namespace sextant
