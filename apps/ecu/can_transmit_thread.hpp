#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "ecu/crossings.hpp"
#include "ecu/worker.hpp"
#include "sextant/comms/can_bus.hpp"
#include "sextant/comms/status_encoder.hpp"

namespace sextant::ecu {

/// The transmit thread: sends the status frames by their cycle times, faults when they change, and at the end
/// the state in which the drive was left. Of a silent control thread it tells what is true, not what that
/// thread said last. Of trouble with the bus as a whole it warns, once.
class CanTransmitThread {
 public:
  /// `warn` is called from this thread with a sentence for people.
  CanTransmitThread(
      CanBus& bus, Crossings& crossings,
      std::function<void(const std::string& sentence)> warn = [](const std::string&) {})
      : bus_{bus}, crossings_{crossings}, warn_{std::move(warn)} {}

  void start() {
    worker_.start([this] { run(); });
  }
  void join() { worker_.join(); }
  /// The body of the loop at now_ns: sends what is due and returns when to look again. [ns]
  std::int64_t look(std::int64_t now_ns);
  /// The end: what is due, and the state in which the drive was left, whatever its cycle says.
  void look_last(std::int64_t now_ns);
  /// Values that did not fit into their signals; for after the join. [-]
  [[nodiscard]] std::uint64_t clamped() const noexcept { return encoder_.clamped(); }

 private:
  void run();
  void send_due(std::int64_t now_ns);
  void warn_of_trouble(std::int64_t now_ns);
  [[nodiscard]] StatusExtras extras();

  CanBus& bus_;
  Crossings& crossings_;
  std::function<void(const std::string& sentence)> warn_;
  StatusEncoder encoder_{};
  std::int64_t next_check_ns_{0};
  bool warned_{false};
  Worker worker_{"sextant-can-tx"};
};

}  // namespace sextant::ecu
