#include "common/fault_injection.hpp"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <sstream>
#include <string_view>
#include <utility>

#include <spdlog/spdlog.h>

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

/// The sentences of a problem, without the name of an option that nobody typed in a request and without the
/// kind that no request makes.
std::string reply_of(const std::exception& problem) {
  constexpr std::string_view option = "--set: ";
  const std::string kind = std::string{" or \""} + power_up_fault + "\"";
  std::string reply;
  std::istringstream lines{problem.what()};
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(option)) line.erase(0, option.size());
    if (const std::size_t k = line.find(kind); k != std::string::npos) line.erase(k, kind.size());
    reply += (reply.empty() ? "" : "\n") + line;
  }
  return reply;
}

}  // namespace

std::vector<std::string> fault_overrides(const std::string& request) {
  std::vector<std::string> overrides;
  std::istringstream lines{request};
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) overrides.push_back("plant.faults." + line);
  }
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
