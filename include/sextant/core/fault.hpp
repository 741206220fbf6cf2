#pragma once

#include <bit>
#include <cstdint>

#include "sextant/core/fault_list.hpp"

namespace sextant {

/// A set of faults as bits, bit = value of Fault.
class FaultSet {
 public:
  constexpr void set(Fault f) noexcept { bits_ |= std::uint64_t{1} << unsigned(f); }
  [[nodiscard]] constexpr bool test(Fault f) const noexcept { return (bits_ >> unsigned(f)) & 1U; }
  [[nodiscard]] constexpr bool any() const noexcept { return bits_ != 0; }
  [[nodiscard]] constexpr int count() const noexcept { return std::popcount(bits_); }
  [[nodiscard]] constexpr std::uint64_t bits() const noexcept { return bits_; }
  constexpr FaultSet& operator|=(FaultSet o) noexcept {
    bits_ |= o.bits_;
    return *this;
  }
  friend constexpr bool operator==(FaultSet, FaultSet) noexcept = default;

 private:
  std::uint64_t bits_{0};
};

}  // namespace sextant
