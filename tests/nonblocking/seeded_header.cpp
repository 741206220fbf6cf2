// Seeded violation in a header of the project. scripts/check_function_effects --self-test must find it.
#include "nonblocking/seeded_header.hpp"

namespace sextant {

std::size_t seeded_history() {
  SeededHistory history;
  history.add(1.0);
  return history.size();
}

}  // namespace sextant
