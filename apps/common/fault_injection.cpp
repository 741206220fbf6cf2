#include "common/fault_injection.hpp"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <utility>

#include <spdlog/spdlog.h>

#include "common/request_text.hpp"
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

/// The sentences of a problem, without the kind that no request makes.
std::string reply_of(const std::exception& problem) {
  const std::string kind = std::string{" or \""} + power_up_fault + "\"";
  std::string reply;
  for (std::string line : request_lines(problem_text(problem))) {
    if (const std::size_t k = line.find(kind); k != std::string::npos) line.erase(k, kind.size());
    reply += (reply.empty() ? "" : "\n") + line;
  }
  return reply;
}

}  // namespace

std::vector<std::string> fault_overrides(const std::string& request) {
  std::vector<std::string> overrides;
  for (const std::string& line : request_lines(request)) overrides.push_back("plant.faults." + line);
  return overrides;
}

FaultInjection::FaultInjection(const std::string& socket, FaultableDriveIo& io, Read read)
    : io_{io},
      read_{std::move(read)},
      is_swapped_{read_({}).kind == PlantFaultKind::cables_swapped},
      socket_{socket, [this](const std::string& request) { return answer(request); }} {}

std::string FaultInjection::answer(const std::string& request) {
  if (request == "describe") return plant_fault_keys();
  if (is_swapped_)
    return "the motor cables are swapped from power-up on, and a fault would take their place: set another "
           "plant.faults.kind in the file";
  try {
    const PlantFaultParameters fault = read_(fault_overrides(request));
    if (fault.kind == PlantFaultKind::cables_swapped)
      return "motor cables are swapped from power-up on: set plant.faults.kind in the file";
    io_.store(fault);
  } catch (const std::exception& problem) {
    return reply_of(problem);
  }
  spdlog::warn("plant fault injected at {:.6f} s: {}", double(now_ns()) * 1e-9, joined(request));
  return "ok";
}

}  // namespace sextant
