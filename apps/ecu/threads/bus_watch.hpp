#pragma once

#include <cstdint>
#include <string>

#include "sextant/comms/can_bus.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {

/// Finds a problem of the whole bus, once.
class BusWatch {
 public:
  explicit BusWatch(CanBus& bus) noexcept : bus_{bus} {}

  /// A sentence for people the first time that there is a problem, else empty; reads the bus once a second.
  /// [ns]
  [[nodiscard]] std::string poll(std::int64_t now_ns) {
    if (found_ || now_ns < next_ns_) return {};
    next_ns_ = now_ns + ns_per_s;
    std::string trouble = bus_.trouble();
    found_ = !trouble.empty();
    return trouble;
  }

 private:
  CanBus& bus_;
  std::int64_t next_ns_{0};
  bool found_{false};
};

}  // namespace sextant::ecu
