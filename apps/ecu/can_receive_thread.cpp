#include "ecu/can_receive_thread.hpp"

#include <chrono>
#include <thread>

#include "ecu/flood_limit.hpp"
#include "sextant/realtime/monotonic_clock.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

void CanReceiveThread::run() {
  using namespace std::chrono_literals;
  // A refusal is the control thread's as well, which reports it.
  if (fifo_priority_ > 0) (void)use_fifo_scheduling(fifo_priority_);
  CanFrame frame;
  FloodLimit flood;
  while (!crossings_.stopped.load(std::memory_order_acquire)) {
    const std::int64_t asked_ns = now_ns();
    const CanReceive result = bus_.receive(frame, 20ms);
    // These come without waiting; what is queued behind a broken socket cannot be read anyway.
    if (result == CanReceive::down || result == CanReceive::error) std::this_thread::sleep_for(5ms);
    if (result == CanReceive::got && take(frame)) hand_over_.record(now_ns() - frame.received_ns);
    if (result == CanReceive::got && flood.see(asked_ns, frame.received_ns)) {
      std::this_thread::sleep_for(std::chrono::nanoseconds{FloodLimit::pause_ns});
    }
  }
}

bool CanReceiveThread::take(const CanFrame& frame) {
  const FrameVerdict verdict = receiver_.on_frame(frame);
  if (verdict == FrameVerdict::unrelated) return false;
  if (verdict == FrameVerdict::other_drive) {
    crossings_.other_drive_ns.store(frame.received_ns, std::memory_order_relaxed);
    return false;
  }
  crossings_.command.store(receiver_.command());
  crossings_.commands_accepted.store(receiver_.count(FrameVerdict::accepted), std::memory_order_relaxed);
  crossings_.commands_rejected.store(receiver_.rejected(), std::memory_order_relaxed);
  return verdict == FrameVerdict::accepted;
}

}  // namespace sextant::ecu
