#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include <unistd.h>

#include "sextant/core/drive_io.hpp"
#include "sextant/hil/plant_server.hpp"
#include "sextant/hil/shared_memory_drive_io.hpp"
#include "sextant/hil/shared_memory_link.hpp"
#include "sextant/hil/shared_memory_plant_end.hpp"
#include "sextant/realtime/periodic_task.hpp"

namespace sextant::audit {

/// A power stage behind a link in shared memory, with a thread that runs it as sextant-plant does. How late
/// that thread is does not matter here: both sides put up with it.
class LinkedPlant {
 public:
  /// The power stage is not owned and belongs to this object's thread until stop().
  LinkedPlant(DriveIo<double>& stage, std::int32_t period_ns)
      : plant_link_{parameters(), LinkRole::plant, period_ns},
        drive_link_{parameters(), LinkRole::drive, period_ns},
        end_{plant_link_},
        server_{
            {.period_ns = period_ns, .hold_periods = 1'000'000, .pattern_timeout_ns = long_ns}, stage, end_},
        task_{{.period_ns = period_ns, .wake_every_periods = 1}},
        thread_{[this] { run(); }} {}
  LinkedPlant(const LinkedPlant&) = delete;
  LinkedPlant& operator=(const LinkedPlant&) = delete;
  ~LinkedPlant() { stop(); }

  void stop() {
    stop_.store(true, std::memory_order_release);
    if (thread_.joinable()) thread_.join();
  }

  [[nodiscard]] DriveIo<double>& drive_io() noexcept { return drive_io_; }
  /// Patterns that the plant has taken; once stopped. [-]
  [[nodiscard]] std::uint64_t patterns() const noexcept { return server_.guard().counters().commands; }
  /// Measurements that the drive has got; once its thread has ended. [-]
  [[nodiscard]] std::uint64_t measurements() const noexcept {
    return drive_io_.counts()->measurements.records;
  }

 private:
  static constexpr std::int64_t long_ns = 1'000'000'000;

  static HilParameters parameters() {
    HilParameters p;
    p.link = "sextant_audit_" + std::to_string(getpid());
    return p;
  }

  void run() {
    task_.start();
    while (!stop_.load(std::memory_order_acquire)) server_.step(task_.wait().deadline_ns);
  }

  SharedMemoryLink plant_link_;
  SharedMemoryLink drive_link_;
  SharedMemoryDriveIo drive_io_{
      drive_link_,
      {.measurement_timeout_ns = long_ns, .missing_periods = 1'000'000, .unacknowledged_periods = 1'000'000}};
  SharedMemoryPlantEnd end_;
  PlantServer<SharedMemoryPlantEnd> server_;
  PeriodicTask task_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace sextant::audit
