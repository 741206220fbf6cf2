#include "common/fault_injection.hpp"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

#include "common/request_text.hpp"
#include "sextant/config/config_error.hpp"
#include "sextant/config/sensor_config.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant {
namespace {

/// On one line.
std::string joined(const std::string& request) {
  std::string text = request;
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace_if(text.begin(), text.end(), [](unsigned char c) { return c < ' '; }, ' ');
  return text;
}

}  // namespace

FaultInjection::FaultInjection(const std::string& socket, FaultableDriveIo& io,
                               const PlantFaultParameters& configured, std::string log_prefix)
    : io_{io},
      configured_{configured},
      log_prefix_{std::move(log_prefix)},
      socket_{socket, [this](const std::string& request) { return answer(request); }} {}

std::string FaultInjection::answer(const std::string& request) {
  if (request == "describe") return plant_fault_keys();
  if (configured_.kind == PlantFaultKind::cables_swapped)
    return "the motor cables are swapped from power-up on, and a fault would take their place: set another "
           "plant.faults.kind in the file";
  try {
    io_.store(requested_fault(request, configured_));
  } catch (const ConfigError& error) {
    return problem_text(error);
  }
  spdlog::warn("{}plant fault injected at {:.6f} s: {}", log_prefix_, double(now_ns()) * 1e-9,
               joined(request));
  return "ok";
}

}  // namespace sextant
