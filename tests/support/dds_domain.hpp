#pragma once

/// @file
/// DDS domains of tests that run at the same time.

#include <cstdint>
#include <string_view>

#include <gtest/gtest.h>

namespace sextant::testing {

/// A domain for the running case alone: `first`, counted on by the case's place in its suite. ctest runs each
/// case in a process of its own, two at a time, and drives of one domain hear each other. Suites keep their
/// ranges apart below 40; the Python tests begin there.
inline std::uint32_t dds_domain(std::uint32_t first) {
  const ::testing::UnitTest& unit = *::testing::UnitTest::GetInstance();
  const ::testing::TestSuite& suite = *unit.current_test_suite();
  std::uint32_t place = 0;
  while (std::string_view{suite.GetTestInfo(static_cast<int>(place))->name()} !=
         unit.current_test_info()->name())
    ++place;
  return first + place;
}

}  // namespace sextant::testing
