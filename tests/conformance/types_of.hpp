#pragma once

#include <tuple>

#include <gtest/gtest.h>

namespace sextant::test {

/// The list of a typed test that the types of a std::tuple make.
template <class List>
struct TypesOf;
template <class... C>
struct TypesOf<std::tuple<C...>> {
  using Types = testing::Types<C...>;
};

}  // namespace sextant::test
