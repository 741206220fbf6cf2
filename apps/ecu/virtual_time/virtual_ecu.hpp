#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "ecu/unit/fault_reaction.hpp"
#include "ecu/virtual_time/virtual_unit.hpp"
#include "sextant/virtual_time/virtual_can_bus.hpp"
#include "sextant/virtual_time/virtual_timeline.hpp"

namespace sextant::ecu {

/// The process of live drives in virtual time: the drives' tasks run one after the other, on their shared
/// states, and no thread exists. A frame is received by every drive when it arrives; then, drive by drive,
/// the control periods of a wake-up run, the watchdog is polled and status is sent. Execution takes no
/// virtual time; `LateWakes` lists the late wake-ups. Threads, DDS and the machine's clock are left out.
class VirtualEcu {
 public:
  /// Clock, bus and the parts of the drives are not owned and must outlive this object.
  VirtualEcu(std::vector<VirtualUnit::Parts> drives, const VirtualClock& clock, VirtualCanBus& bus,
             OnFault on_fault = OnFault::others_go_on);
  VirtualEcu(const VirtualEcu&) = delete;
  VirtualEcu& operator=(const VirtualEcu&) = delete;

  /// Adds its tasks: reception, those of each drive, and what a fault of one means for the others.
  void join(VirtualTimeline& timeline);

  /// Torque to zero, gates off, stop; as SIGTERM in the live drive.
  void shut_down() noexcept {
    for (VirtualUnit& drive : drives_) drive.shut_down();
  }
  /// A fault of one drive has ended the run.
  [[nodiscard]] bool has_ended() const noexcept { return reaction_.has_ended(); }
  /// True once every drive has shut down and sent its last status.
  [[nodiscard]] bool stopped() const noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return drives_.size(); }
  [[nodiscard]] VirtualUnit& drive(std::size_t k) { return drives_.at(k); }
  [[nodiscard]] const VirtualUnit& drive(std::size_t k) const { return drives_.at(k); }

 private:
  [[nodiscard]] bool is_running() const noexcept;
  void receive();
  void react_to_faults();

  const VirtualClock& clock_;
  VirtualCanBus& bus_;
  FaultReaction reaction_;
  std::int64_t next_reaction_ns_;
  std::deque<VirtualUnit> drives_{};  // each stays where it is
};

}  // namespace sextant::ecu
