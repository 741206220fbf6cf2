#pragma once

#include <stdexcept>
#include <string>

#include "sextant/comms/can_bus.hpp"

namespace sextant::testing {

/// The sentence with which an address is refused; empty where it is not.
inline std::string refusal(const std::string& address) {
  try {
    (void)make_can_bus(address);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}

}  // namespace sextant::testing
