#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "sextant/hil/drive_report.hpp"
#include "sextant/hil/link_records.hpp"
#include "sextant/hil/record_ring.hpp"
#include "sextant/hil/sequence_cell.hpp"
#include "sextant/realtime/cache_line.hpp"

namespace sextant {

/// "SEXTHIL" and a zero, as the bytes lie in memory.
inline constexpr std::uint64_t link_magic = 0x004C494854584553;

/// The beginning of the shared memory. Magic, version and size stay where they are in every version.
struct LinkHeader {
  std::uint64_t magic{};
  std::uint32_t layout_version{};
  std::uint32_t size_bytes{};  ///< of the whole [bytes]
  std::int64_t period_ns{};    ///< plant and control period [ns]
  std::uint32_t pacing{};      ///< as `Pacing`
  std::uint32_t reserved{};
};

/// State of one side, written by that side alone. Its heartbeat is the sequence of the records that it writes
/// once a period, `command` or `measurements`.
struct alignas(cache_line) LinkSide {
  std::atomic<std::uint32_t> generation{0};  ///< grows with each start; 0: never there [-]
  std::atomic<std::uint32_t> present{0};     ///< 1 until the side announces its end
  std::atomic<std::uint32_t> doorbell{0};    ///< lockstep: changes with each record for the other side [-]
  std::atomic<std::uint32_t> asleep{0};      ///< lockstep: 1 while it sleeps on the other's doorbell
};

/// The whole link as it lies in shared memory: zero bytes are its valid empty state.
struct LinkMemory {
  static constexpr std::size_t ring_capacity = 1024;

  alignas(cache_line) LinkHeader header{};
  LinkSide plant{};
  LinkSide drive{};
  /// The drive's generation while the gates may be on, else 0. Set by the drive when it shows gates off,
  /// cleared by its watchdog and at the drive's end.
  alignas(cache_line) std::atomic<std::uint32_t> gate_enable{0};
  alignas(cache_line) SequenceCell<DrivePatternRecord> command{};
  SequenceCell<DriveReport>
      report{};  ///< lockstep, of a run that is observed; its number is that of a `command`
  alignas(cache_line) RecordRing<MeasurementRecord, ring_capacity> measurements{};
};

static_assert(sizeof(LinkHeader) == 32 && std::is_trivially_copyable_v<LinkHeader>);
static_assert(offsetof(LinkHeader, layout_version) == 8 && offsetof(LinkHeader, size_bytes) == 12);
static_assert(sizeof(LinkSide) == cache_line && offsetof(LinkSide, asleep) == 12);
static_assert(sizeof(SequenceCell<DrivePatternRecord>) == 80 &&
              sizeof(SequenceCell<MeasurementRecord>) == 128);
static_assert(offsetof(LinkMemory, plant) == 64 && offsetof(LinkMemory, drive) == 128);
static_assert(offsetof(LinkMemory, gate_enable) == 192 && offsetof(LinkMemory, command) == 256);
static_assert(offsetof(LinkMemory, report) == 336);
static_assert(offsetof(LinkMemory, measurements) == 384 && sizeof(LinkMemory) == 131'520);
static_assert(std::is_standard_layout_v<LinkMemory>);
static_assert(std::atomic<std::uint64_t>::is_always_lock_free &&
                  std::atomic<std::int64_t>::is_always_lock_free &&
                  std::atomic<std::uint32_t>::is_always_lock_free,
              "atomics that lock do not work between processes");

}  // namespace sextant
