#pragma once

#include <mutex>
#include <thread>
#include <vector>

#include "sextant/comms/can_bus.hpp"

namespace sextant::test {

/// Keeps what was sent; nothing ever arrives.
class FakeCanBus final : public CanBus {
 public:
  [[nodiscard]] CanSend send(const CanFrame& frame) noexcept override {
    const std::scoped_lock lock{mutex_};
    if (answer_ == CanSend::ok) sent_.push_back(frame);
    return answer_;
  }
  [[nodiscard]] CanReceive receive(CanFrame&, std::chrono::nanoseconds timeout) noexcept override {
    std::this_thread::sleep_for(timeout);
    return CanReceive::timeout;
  }
  [[nodiscard]] CanBusStats stats() const noexcept override { return {}; }

  [[nodiscard]] std::vector<CanFrame> sent() const {
    const std::scoped_lock lock{mutex_};
    return sent_;
  }

  /// What `send` returns from now on.
  void answer(CanSend answer) {
    const std::scoped_lock lock{mutex_};
    answer_ = answer;
  }

 private:
  mutable std::mutex mutex_{};
  std::vector<CanFrame> sent_{};
  CanSend answer_{CanSend::ok};
};

}  // namespace sextant::test
