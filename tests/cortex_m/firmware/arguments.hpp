#pragma once

#include <cstddef>
#include <cstdint>

#include "semihosting.hpp"

namespace sextant::golden {

/// `Count` names after the program's, in place.
template <std::size_t Count>
struct Arguments {
  char line[256]{};
  const char* names[Count]{};

  [[nodiscard]] bool read() {
    struct {
      char* text;
      std::int32_t size;
    } block{line, sizeof line};
    if (semihosting::detail::call(0x15, &block) != 0) return false;
    std::size_t count = 0;
    for (char* c = line; *c != '\0'; ++c) {
      if (*c != ' ') continue;
      *c = '\0';
      if (count < Count) names[count++] = c + 1;
    }
    return count == Count;
  }
};

}  // namespace sextant::golden
