#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

#include "sextant/config/ecu_config.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/hil/lockstep_drive_io.hpp"
#include "sextant/hil/shared_memory_drive_io.hpp"
#include "sextant/hil/shared_memory_link.hpp"
#include "sextant/hil/udp_drive_io.hpp"
#include "sextant/sim/simulated_power_stage.hpp"

namespace sextant::ecu {

/// The power stage behind the drive's `DriveIo`, by `power_stage` of the configuration: the simulated plant
/// in this process, or a link to a plant in another one.
class PowerStage {
 public:
  /// What the drive knows of a plant at the other end of a link.
  enum class Plant : std::uint8_t {
    unknown,
    timed_out,       ///< no measurements come
    unacknowledged,  ///< its measurements come, the drive's patterns do not reach it
    answers
  };

  /// Throws std::runtime_error with one sentence where it cannot be had.
  explicit PowerStage(const EcuConfig& config);

  [[nodiscard]] DriveIo<double>& io() noexcept { return *io_; }

  /// Takes the gate-enable line away, where there is one; from any thread.
  void inhibit_gates() noexcept;

  /// Reports to the plant that the drive leaves in order; once the control thread has ended.
  void say_goodbye() noexcept;

  /// One sentence when the plant has appeared, timed out, does not acknowledge patterns, or kept its gates
  /// off against a pattern since the last call, else empty. For one thread.
  [[nodiscard]] std::string state_change();

  /// Why there is no use in going on: the plant of a lockstep is gone. Empty where there is none; from any
  /// thread.
  [[nodiscard]] std::string problem() const;

  /// What crossed the link, for people; once the control thread has ended.
  void print_report(std::FILE* out) const;

 private:
  void join_shared_memory(const EcuConfig& config);

  std::unique_ptr<SimulatedPowerStage> simulated_{};
  std::unique_ptr<SharedMemoryLink> link_{};
  std::unique_ptr<SharedMemoryDriveIo> shared_memory_{};
  std::unique_ptr<LockstepDriveIo> lockstep_{};
  std::unique_ptr<UdpDriveIo> udp_{};
  std::string link_name_{};
  DriveIo<double>* io_{nullptr};
  Plant reported_{Plant::unknown};
  std::uint64_t reported_refusals_{0};
};

}  // namespace sextant::ecu
