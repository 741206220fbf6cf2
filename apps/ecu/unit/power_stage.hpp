#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

#include "common/fault_injection.hpp"
#include "sextant/config/ecu_config.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/core/supervised_drive_io.hpp"
#include "sextant/hil/linked_drive_io.hpp"
#include "sextant/hil/lockstep_drive_io.hpp"
#include "sextant/hil/shared_memory_link.hpp"
#include "sextant/power_stage/live_power_stage.hpp"

namespace sextant::ecu {

/// The power stage of the drive's `DriveIo`, by `power_stage` of the configuration: the simulated plant in
/// this process, a link to a plant in another one, or what the program brings.
class PowerStage {
 public:
  /// State of a plant at the other end of a link.
  enum class Plant : std::uint8_t {
    unknown,
    timed_out,       ///< no measurements arrive
    unacknowledged,  ///< measurements arrive; the plant acknowledges no pattern
    answers
  };

  /// Throws std::runtime_error with one sentence where it cannot be opened. fault_socket: on which the
  /// simulated plant takes faults; empty for none. log_prefix: of its lines in the log.
  explicit PowerStage(const EcuConfig& config, const std::string& fault_socket = {},
                      const std::string& log_prefix = {});

  [[nodiscard]] DriveIo<double>& io() noexcept { return *io_; }

  /// Turns the gates off, where the power stage has a way beside the control thread; from any thread.
  void inhibit_gates() noexcept;

  /// Announces the orderly end of the drive to the power stage; once the control thread has ended.
  void announce_end() noexcept;

  /// In lockstep, for a plant that observes a scenario: a control period that has run, time zero of the
  /// scenario [ns] and its mark.
  void report(const Telemetry<double>& telemetry, std::int64_t begin_ns, std::uint32_t scenario) noexcept {
    if (lockstep_) lockstep_->report(to_report(telemetry, begin_ns, scenario));
  }

  /// Takes the fault that waits at the socket; from the thread that calls state_change().
  void poll_faults() {
    if (faults_) faults_->poll();
  }

  /// One sentence when, since the last call, the plant has appeared, timed out, stopped acknowledging
  /// patterns, or kept its gates off against a pattern; else empty. For one thread.
  [[nodiscard]] std::string state_change();

  /// Why the run must end: the plant of a lockstep has ended or timed out, or what the program brings is
  /// lost. Empty while it runs; from any thread.
  [[nodiscard]] std::string problem() const;

  /// Counts of the link, for people; once the control thread has ended.
  void print_report(std::FILE* out) const;

 private:
  void simulate(const EcuConfig& config, const std::string& fault_socket, const std::string& log_prefix);
  void join_shared_memory(const EcuConfig& config);
  void open_own(const EcuConfig& config);

  std::unique_ptr<LivePowerStage> simulated_{};
  std::unique_ptr<FaultInjection> faults_{};
  std::unique_ptr<SharedMemoryLink> memory_{};
  std::unique_ptr<LinkedDriveIo> link_{};
  LockstepDriveIo* lockstep_{nullptr};  // the link, where it is one
  std::unique_ptr<DriveIo<double>> own_{};
  std::string name_{};  // of the link, or of what the program brings
  DriveIo<double>* io_{nullptr};
  SupervisedDriveIo<double>* supervised_{nullptr};  // the same, where it is one
  Plant reported_{Plant::unknown};
  std::uint64_t reported_refusals_{0};
};

}  // namespace sextant::ecu
