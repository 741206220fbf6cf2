#pragma once

namespace sextant::bench {

/// Makes the compiler believe that the object is used, without copying it.
template <class Object>
void keep(const Object& object) {
  asm volatile("" : : "r"(&object) : "memory");
}

}  // namespace sextant::bench
