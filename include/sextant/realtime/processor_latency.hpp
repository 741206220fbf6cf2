#pragma once

#include <string>

namespace sextant {

/// Keeps the processors out of sleep states that take time to leave, during the lifetime of the object:
/// requests a latency of 0 us from the kernel's power management (PM QoS,
/// Documentation/power/pm_qos_interface). Without effect where that is refused or the kernel has no such
/// file.
class ProcessorLatency {
 public:
  explicit ProcessorLatency(bool wanted, const std::string& path = "/dev/cpu_dma_latency");
  ~ProcessorLatency();
  ProcessorLatency(const ProcessorLatency&) = delete;
  ProcessorLatency& operator=(const ProcessorLatency&) = delete;

  [[nodiscard]] bool granted() const noexcept { return file_ >= 0; }

 private:
  int file_{-1};  // the request ends with it
};

}  // namespace sextant
