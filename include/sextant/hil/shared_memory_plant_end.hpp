#pragma once

#include <cstdint>

#include "sextant/core/nonblocking.hpp"
#include "sextant/hil/link_memory.hpp"
#include "sextant/hil/shared_memory_link.hpp"

namespace sextant {

/// The plant's end of a link in shared memory.
class SharedMemoryPlantEnd {
 public:
  static constexpr bool same_clock = true;  ///< both sides read the clock of one machine

  /// The link is held by a plant and must outlive this object.
  explicit SharedMemoryPlantEnd(SharedMemoryLink& link) noexcept
      : memory_{link.memory()}, generation_{link.generation()} {
    // A pattern of an earlier drive does not count.
    (void)memory_.command.load(command_);
  }

  /// The newest pattern; false when none has come since the last call.
  [[nodiscard]] bool take(DrivePatternRecord& command) noexcept SEXTANT_NONBLOCKING {
    DrivePatternRecord found;
    if (memory_.command.load(found) == 0) return false;
    if (found.sequence == command_.sequence && found.generation == command_.generation) return false;
    command_ = found;
    command = found;
    return true;
  }

  /// The gate-enable line of the drive whose pattern came last.
  [[nodiscard]] bool gates_enabled() const noexcept SEXTANT_NONBLOCKING {
    const std::uint32_t line = memory_.gate_enable.load(std::memory_order_acquire);
    return line != 0 && line == command_.generation;
  }

  [[nodiscard]] bool drive_present() const noexcept SEXTANT_NONBLOCKING {
    return memory_.drive.present.load(std::memory_order_acquire) != 0;
  }

  void publish(MeasurementRecord record) noexcept SEXTANT_NONBLOCKING {
    record.generation = generation_;
    record.sequence = ++sequence_;
    memory_.measurements.push(record);
  }

 private:
  LinkMemory& memory_;
  std::uint32_t generation_;
  DrivePatternRecord command_{};
  std::uint64_t sequence_{0};
};

}  // namespace sextant
