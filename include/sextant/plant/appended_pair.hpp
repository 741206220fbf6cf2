#pragma once

#include <cstddef>
#include <span>
#include <utility>

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/appended_system.hpp"

namespace sextant {

/// Two appended systems as one; the states of the second follow those of the first.
template <class First, class Second, class T = double>
  requires AppendedSystem<First, T> && AppendedSystem<Second, T>
struct AppendedPair {
  static constexpr int size = First::size + Second::size;
  static constexpr bool is_integral = sextant::is_integral<First> && sextant::is_integral<Second>;
  static constexpr bool last_is_uncontrolled = sextant::last_is_uncontrolled<Second>;
  static constexpr int second_begin = First::size;  ///< index of the second system's first state

  First first;
  Second second;

  constexpr AppendedPair(First a, Second b) noexcept : first{std::move(a)}, second{std::move(b)} {}

  /// Both derivatives, in the units of each.
  constexpr void derivative(const PlantQuantities<T>& plant, std::span<const T, std::size_t(size)> y,
                            std::span<T, std::size_t(size)> dy) const noexcept SEXTANT_NONBLOCKING {
    constexpr auto head = std::size_t(First::size);
    constexpr auto tail = std::size_t(Second::size);
    first.derivative(plant, y.template first<head>(), dy.template first<head>());
    second.derivative(plant, y.template last<tail>(), dy.template last<tail>());
  }
};

}  // namespace sextant
