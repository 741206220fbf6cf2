#pragma once

#include <string>

namespace sextant {

/// Keeps the processors out of sleep states that take time to leave, for as long as the object lives: the
/// kernel's power management is told to be back within 0 us (PM QoS, Documentation/power/pm_qos_interface).
/// Where that is refused, or the kernel has no such file, nothing changes.
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
