#pragma once

#include <atomic>
#include <cstddef>

#include "ecu/shared/shared_state.hpp"
#include "sextant/comms/can_frame.hpp"
#include "sextant/comms/command_receiver.hpp"

namespace sextant::ecu {

/// The work of the receive thread, without the thread: checks identity, end-to-end protection and range of
/// every frame, and stores the newest command for the control thread. Reads no clock.
class ReceiveTask {
 public:
  /// offset: of the drive's identifiers.
  explicit ReceiveTask(SharedState& shared, IdentifierOffset offset = {}) noexcept
      : shared_{shared}, receiver_{{.identifier_offset = offset}} {}

  /// True for an accepted command.
  bool on_frame(const CanFrame& frame) {
    const FrameVerdict verdict = receiver_.on_frame(frame);
    if (verdict == FrameVerdict::unrelated) return false;
    if (verdict == FrameVerdict::other_drive) {
      shared_.other_drive_ns.store(frame.received_ns, std::memory_order_relaxed);
      return false;
    }
    shared_.command.store(receiver_.command());
    shared_.frames[std::size_t(verdict)].store(receiver_.count(verdict), std::memory_order_relaxed);
    return verdict == FrameVerdict::accepted;
  }

  /// Counts of the frames; once the thread has ended.
  [[nodiscard]] const CommandReceiver& receiver() const noexcept { return receiver_; }

 private:
  SharedState& shared_;
  CommandReceiver receiver_;
};

}  // namespace sextant::ecu
