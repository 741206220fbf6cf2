#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "sextant/hil/doorbell.hpp"
#include "sextant/hil/drive_report.hpp"
#include "sextant/hil/link_memory.hpp"
#include "sextant/hil/linked_drive_io.hpp"
#include "sextant/hil/shared_memory_link.hpp"

namespace sextant {

/// A power stage in another process of this machine, in virtual time: read(t) sends the pattern written last,
/// requests the plant's advance to t, and waits for the measurement. The drive's time is the only clock; two
/// runs are equal bit by bit. The actuation delay is that of the plant's configuration.
class LockstepDriveIo final : public LinkedDriveIo {
 public:
  /// The link is held by a drive and must outlive this object. Waits for the plant for at most
  /// `timeout_ns` [ns] a read.
  LockstepDriveIo(SharedMemoryLink& link, std::int64_t timeout_ns) noexcept;

  /// Not plausible, without waiting, once the plant is lost.
  [[nodiscard]] Measurement<double> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING override;

  void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override {
    pattern_ = pattern;
    has_pattern_ = true;
  }

  /// What the next request tells the plant of the control period before it.
  void report(const DriveReport& report) noexcept SEXTANT_NONBLOCKING {
    report_ = report;
    has_report_ = true;
  }

  void inhibit_gates() noexcept override {}
  void announce_end() noexcept override { link_.announce_end(); }
  [[nodiscard]] const LinkState* link_state() const noexcept override { return nullptr; }
  [[nodiscard]] std::optional<Counts> counts() const noexcept override { return std::nullopt; }
  [[nodiscard]] const char* loss() const noexcept override;

  /// True once the plant has ended or timed out, for the rest of the run; from any thread.
  [[nodiscard]] bool lost() const noexcept { return lost_.load(std::memory_order_acquire); }
  /// True once the plant has sent a measurement; from any thread.
  [[nodiscard]] bool joined() const noexcept { return joined_.load(std::memory_order_relaxed); }
  /// True once a plant has held the link, with or without a measurement; from any thread.
  [[nodiscard]] bool was_there() const noexcept { return was_there_.load(std::memory_order_relaxed); }

 private:
  void request(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING;
  [[nodiscard]] bool answer(MeasurementRecord& record) noexcept SEXTANT_NONBLOCKING;
  [[nodiscard]] bool wait_for_answer(MeasurementRecord& record) noexcept SEXTANT_NONBLOCKING;

  SharedMemoryLink& link_;
  LinkMemory& memory_;
  std::int64_t timeout_ns_;
  Doorbell own_bell_;
  Doorbell plant_bell_;
  GatePattern pattern_{};
  std::uint64_t sequence_;
  std::uint32_t plant_generation_{0};
  bool has_pattern_{false};
  DriveReport report_{};
  bool has_report_{false};
  std::atomic<bool> joined_{false};
  std::atomic<bool> was_there_{false};
  std::atomic<bool> lost_{false};
};

}  // namespace sextant
