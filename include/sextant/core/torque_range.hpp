#pragma once

namespace sextant {

/// Range of the available torque.
template <class T = double>
struct TorqueRange {
  T lowest{};   ///< signed, not above zero [N·m]
  T highest{};  ///< signed, not below zero [N·m]
};

}  // namespace sextant
