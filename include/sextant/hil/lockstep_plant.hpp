#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "sextant/core/drive_io.hpp"
#include "sextant/hil/doorbell.hpp"
#include "sextant/hil/drive_report.hpp"
#include "sextant/hil/link_memory.hpp"
#include "sextant/hil/shared_memory_link.hpp"

namespace sextant {

/// Runs a power stage in virtual time for a drive in another process: waits for a request, advances to its
/// time with its pattern, sends the measurement. Without a request virtual time does not advance.
class LockstepPlant {
 public:
  enum class Outcome : std::uint8_t {
    stepped,  ///< a request was answered
    waiting,  ///< no request within 20 ms; the drive is absent or still computes
    left,     ///< the drive has announced its end
    lost      ///< the drive has ended, or sent no request for longer than the timeout
  };

  /// The link is held by a plant. Link and stage are not owned and must outlive this object.
  LockstepPlant(SharedMemoryLink& link, DriveIo<double>& stage, std::int64_t timeout_ns) noexcept;

  /// Called with the drive's report of each control period that has run, the time of that period [ns] and the
  /// measured speed [rad/s], before the plant advances.
  using Observer = std::function<void(const DriveReport& report, std::int64_t t_ns, double omega_m)>;
  void observe(Observer observer) { observer_ = std::move(observer); }

  /// One request. Waits for at most 20 ms.
  [[nodiscard]] Outcome step() noexcept;

  [[nodiscard]] std::uint64_t steps() const noexcept { return sequence_; }
  /// First and last time of the drive, in virtual time. [ns]
  [[nodiscard]] std::int64_t begin_ns() const noexcept { return begin_ns_; }
  [[nodiscard]] std::int64_t end_ns() const noexcept { return end_ns_; }

 private:
  [[nodiscard]] bool take(DrivePatternRecord& command) noexcept;
  [[nodiscard]] Outcome check_for_drive() noexcept;
  void answer(const DrivePatternRecord& command) noexcept;
  void observe_period(const DrivePatternRecord& command);

  SharedMemoryLink& link_;
  LinkMemory& memory_;
  DriveIo<double>& stage_;
  std::int64_t timeout_ns_;
  Doorbell own_bell_;
  Doorbell drive_bell_;
  DrivePatternRecord command_{};
  std::uint64_t sequence_{0};
  std::int64_t waited_ns_{0};
  std::int64_t begin_ns_{0};
  std::int64_t end_ns_{0};
  double omega_m_{0};  // of the last measurement [rad/s]
  Observer observer_{};
};

}  // namespace sextant
