#include "sextant/realtime/processor_latency.hpp"

#include <cstdint>

#include <fcntl.h>
#include <unistd.h>

namespace sextant {

ProcessorLatency::ProcessorLatency(bool wanted, const std::string& path) {
  if (!wanted) return;
  file_ = open(path.c_str(), O_WRONLY | O_CLOEXEC);
  const std::int32_t latency_us = 0;
  if (file_ < 0 || write(file_, &latency_us, sizeof latency_us) == sizeof latency_us) return;
  close(file_);
  file_ = -1;
}

ProcessorLatency::~ProcessorLatency() {
  if (file_ >= 0) close(file_);
}

}  // namespace sextant
