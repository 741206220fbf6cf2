#pragma once

#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Stator and rotor flux linkage [Wb], or their derivatives [V]; stationary frame.
template <class T = double>
struct FluxPair {
  SpaceVector<T> s{};
  SpaceVector<T> r{};
};

}  // namespace sextant
