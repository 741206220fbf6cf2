#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <optional>

#include "sextant/hil/link_memory.hpp"
#include "sextant/hil/link_state.hpp"
#include "sextant/hil/linked_drive_io.hpp"
#include "sextant/hil/measurement_assembler.hpp"
#include "sextant/hil/shared_memory_link.hpp"

namespace sextant {

/// A power stage in another process of this machine, over shared memory in real time. Neither call waits,
/// locks or makes a system call. A pattern is applied from the plant's next period on: an actuation delay of
/// one period.
class SharedMemoryDriveIo final : public LinkedDriveIo {
 public:
  /// The link is held by a drive and must outlive this object.
  SharedMemoryDriveIo(SharedMemoryLink& link, const MeasurementAssembler::Parameters& parameters) noexcept
      : link_{link},
        memory_{link.memory()},
        generation_{link.generation()},
        assembler_{parameters},
        sequence_{memory_.command.number()} {}

  [[nodiscard]] Measurement<double> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING override {
    t_ns_ = t_ns;
    const std::uint64_t newest = memory_.measurements.newest();
    if (!started_ && newest > 0) seen_ = newest - 1;  // records from before the drive's start do not count
    started_ = true;
    // Records that the ring no longer holds are lost; the gap in their numbers counts them.
    if (seen_ < newest) seen_ = std::max(seen_, memory_.measurements.oldest() - 1);
    MeasurementRecord record;
    while (seen_ < newest) {
      ++seen_;
      if (memory_.measurements.read(seen_, record)) assembler_.add(record);
    }
    const Measurement<double> m = assembler_.take(t_ns);
    state_.publish(assembler_);
    return m;
  }

  void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override {
    ++sequence_;
    memory_.command.store({sequence_, t_ns_, to_record(pattern), generation_, 1}, sequence_);
    // A cleared line is set only with gates off: the gates were then off at least once.
    const bool is_off = all_gates_off(pattern);
    assembler_.wrote(sequence_, !is_off);
    std::uint32_t off = 0;
    if (is_off) {
      memory_.gate_enable.compare_exchange_strong(off, generation_, std::memory_order_acq_rel);
    }
  }

  void inhibit_gates() noexcept override { memory_.gate_enable.store(0, std::memory_order_release); }
  void announce_end() noexcept override { link_.announce_end(); }
  [[nodiscard]] const LinkState* link_state() const noexcept override { return &state_; }
  [[nodiscard]] std::optional<Counts> counts() const noexcept override {
    return Counts{.measurements = assembler_.counters()};
  }
  [[nodiscard]] const char* loss() const noexcept override { return nullptr; }

 private:
  SharedMemoryLink& link_;
  LinkMemory& memory_;
  std::uint32_t generation_;
  std::uint64_t seen_{0};
  MeasurementAssembler assembler_;
  bool started_{false};
  std::int64_t t_ns_{0};
  std::uint64_t sequence_;
  LinkState state_{};
};

}  // namespace sextant
