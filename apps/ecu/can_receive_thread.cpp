#include "ecu/can_receive_thread.hpp"

#include <chrono>

#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

void CanReceiveThread::start() {
  thread_ = std::thread{[this] { run(); }};
}

void CanReceiveThread::join() {
  if (thread_.joinable()) thread_.join();
}

void CanReceiveThread::run() {
  using namespace std::chrono_literals;
  (void)name_thread("sextant-can-rx");
  CanFrame frame;
  std::uint64_t accepted = 0;
  while (!crossings_.stopped.load(std::memory_order_acquire)) {
    const CanReceive result = bus_.receive(frame, 20ms);
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
