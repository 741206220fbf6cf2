#pragma once

#include <cstddef>
#include <utility>

namespace sextant {

/// Calls `evaluate.operator()<n>()` for every row n of a table of rules, in order. The table is a template
/// argument, so that each rule is called directly and not through its pointer.
template <const auto& rules, class Evaluate>
constexpr void for_each_rule(const Evaluate& evaluate) noexcept {
  [&]<std::size_t... n>(std::index_sequence<n...>) {
    (evaluate.template operator()<n>(), ...);
  }(std::make_index_sequence<rules.size()>{});
}

}  // namespace sextant
