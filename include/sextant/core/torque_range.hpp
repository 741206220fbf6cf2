#pragma once

#include <algorithm>

namespace sextant {

/// Range of the available torque.
template <class T = double>
struct TorqueRange {
  T lowest{};   ///< signed, not above zero [N·m]
  T highest{};  ///< signed, not below zero [N·m]

  /// The part of the range up to a magnitude [N·m].
  [[nodiscard]] constexpr TorqueRange within(T torque) const noexcept {
    return {std::max(lowest, -torque), std::min(highest, torque)};
  }
};

}  // namespace sextant
