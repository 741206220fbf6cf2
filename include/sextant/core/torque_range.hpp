#pragma once

namespace sextant {

/// The torques that may be asked for.
template <class T = double>
struct TorqueRange {
  T lowest{};   ///< signed, not above zero [N·m]
  T highest{};  ///< signed, not below zero [N·m]
};

}  // namespace sextant
