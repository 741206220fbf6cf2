#pragma once

#include <cstddef>
#include <vector>

#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// Seeded violation: an inline function of a header, no template, that allocates.
class SeededHistory {
 public:
  void add(double value) noexcept SEXTANT_NONBLOCKING { values_.push_back(value); }
  [[nodiscard]] std::size_t size() const noexcept { return values_.size(); }

 private:
  std::vector<double> values_{};
};

}  // namespace sextant
