#pragma once

#include <vector>

#include "virtual_time/command_injections.hpp"
#include "virtual_time/plant_injections.hpp"
#include "virtual_time/sensor_injections.hpp"

namespace sextant::test {

/// Every fault of the contract at least once, and each of the sensors' faults.
inline std::vector<Injection> fault_injections() {
  std::vector<Injection> list = command_injections();
  for (const Injection& injection : sensor_injections()) list.push_back(injection);
  for (const Injection& injection : plant_injections()) list.push_back(injection);
  return list;
}

}  // namespace sextant::test
