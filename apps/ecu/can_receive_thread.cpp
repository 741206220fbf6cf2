#include "ecu/can_receive_thread.hpp"

#include <chrono>
#include <thread>

namespace sextant::ecu {

void CanReceiveThread::run() {
  using namespace std::chrono_literals;
  CanFrame frame;
  std::uint64_t accepted = 0;
  while (!crossings_.stopped.load(std::memory_order_acquire)) {
    const CanReceive result = bus_.receive(frame, 20ms);
    // These come without waiting; what is queued behind a broken socket cannot be read anyway.
    if (result == CanReceive::down || result == CanReceive::error) std::this_thread::sleep_for(5ms);
    if (result != CanReceive::got) continue;
    const FrameVerdict verdict = receiver_.on_frame(frame);
    if (verdict == FrameVerdict::unrelated) continue;
    if (verdict == FrameVerdict::accepted) ++accepted;
    crossings_.command.store(receiver_.command());
    crossings_.commands_accepted.store(accepted, std::memory_order_relaxed);
    crossings_.commands_rejected.store(receiver_.command().rejected, std::memory_order_relaxed);
  }
}

}  // namespace sextant::ecu
