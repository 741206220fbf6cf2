#include "sextant/core/fault.hpp"

#include <set>
#include <string>

#include <gtest/gtest.h>

namespace sextant {
namespace {

TEST(FaultSet, HoldsEachFaultInItsOwnBit) {
  for (int i = 0; i < fault_count; ++i) {
    FaultSet set;
    set.set(static_cast<Fault>(i));
    EXPECT_EQ(set.bits(), std::uint64_t{1} << unsigned(i));
    EXPECT_EQ(set.count(), 1);
    for (int j = 0; j < fault_count; ++j) EXPECT_EQ(set.test(static_cast<Fault>(j)), i == j);
  }
}

TEST(FaultSet, IsEmptyUntilAFaultIsSetAndUnitesSets) {
  FaultSet set;
  EXPECT_FALSE(set.any());
  FaultSet other;
  other.set(Fault::bus_off);
  other.set(Fault::over_current);
  set.set(Fault::over_current);
  set |= other;
  EXPECT_EQ(set, other);
  EXPECT_EQ(set.count(), 2);
}

TEST(Fault, EveryFaultHasANameOfItsOwn) {
  std::set<std::string> names;
  for (int i = 0; i < fault_count; ++i) names.insert(to_string(static_cast<Fault>(i)));
  EXPECT_EQ(names.size(), unsigned(fault_count));
  EXPECT_EQ(names.count("?"), 0U);
}

}  // namespace
}  // namespace sextant
