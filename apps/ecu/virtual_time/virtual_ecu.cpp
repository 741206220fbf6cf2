#include "ecu/virtual_time/virtual_ecu.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace sextant::ecu {

namespace {

std::vector<DriveUnit*> units_of(const std::vector<VirtualUnit::Parts>& drives) {
  std::vector<DriveUnit*> units;
  units.reserve(drives.size());
  for (const VirtualUnit::Parts& parts : drives) units.push_back(&parts.unit);
  return units;
}

}  // namespace

VirtualEcu::VirtualEcu(std::vector<VirtualUnit::Parts> drives, const VirtualClock& clock, VirtualCanBus& bus,
                       OnFault on_fault)
    : clock_{clock}, bus_{bus}, reaction_{on_fault, units_of(drives)}, next_reaction_ns_{clock.now_ns()} {
  for (VirtualUnit::Parts& parts : drives) drives_.emplace_back(std::move(parts), clock);
  bus_.listen([this](const CanFrame& frame) {
    for (VirtualUnit& drive : drives_) drive.sent(frame);
  });
}

void VirtualEcu::join(VirtualTimeline& timeline) {
  timeline.add({.next_due_ns = [this] { return is_running() ? bus_.next_arrival_ns() : never_ns; },
                .act = [this] { receive(); }});
  for (VirtualUnit& drive : drives_) drive.join(timeline);
  if (!reaction_.ends_run()) return;
  timeline.add({.next_due_ns = [this] { return is_running() ? next_reaction_ns_ : never_ns; },
                .act = [this] { react_to_faults(); }});
}

void VirtualEcu::react_to_faults() {
  reaction_.poll(clock_.now_ns());
  next_reaction_ns_ = clock_.now_ns() + WatchdogTask::poll_every_ns;
}

bool VirtualEcu::stopped() const noexcept {
  return std::ranges::all_of(drives_, [](const VirtualUnit& drive) { return drive.stopped(); });
}

bool VirtualEcu::is_running() const noexcept {
  return std::ranges::any_of(drives_, [](const VirtualUnit& drive) { return drive.is_running(); });
}

void VirtualEcu::receive() {
  CanFrame frame;
  while (bus_.receive(frame, std::chrono::nanoseconds{0}) == CanReceive::got) {
    for (VirtualUnit& drive : drives_) drive.receive(frame);
  }
}

}  // namespace sextant::ecu
