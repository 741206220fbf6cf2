#include "sextant/drive/fault_memory.hpp"

#include <gtest/gtest.h>

namespace sextant {
namespace {

FaultSet set_of(std::initializer_list<Fault> faults) {
  FaultSet set;
  for (const Fault f : faults) set.set(f);
  return set;
}

TEST(FaultMemory, LatchesWhatWasActiveAndRemembersTheFirst) {
  FaultMemory memory;
  memory.step({});
  EXPECT_FALSE(memory.latched().any());
  memory.step(set_of({Fault::over_current}));
  memory.step(set_of({Fault::command_lost}));
  memory.step({});
  EXPECT_FALSE(memory.active().any());
  EXPECT_EQ(memory.latched(), set_of({Fault::over_current, Fault::command_lost}));
  EXPECT_EQ(memory.first(), Fault::over_current);
  EXPECT_EQ(memory.total(), 2U);
}

TEST(FaultMemory, AFaultThatLastsCountsOnce) {
  FaultMemory memory;
  for (int i = 0; i < 100; ++i) memory.step(set_of({Fault::bus_off}));
  EXPECT_EQ(memory.total(), 1U);
}

TEST(FaultMemory, AResetForgetsWhatIsLatchedButNotTheTotal) {
  FaultMemory memory;
  memory.step(set_of({Fault::bus_off}));
  memory.reset();
  EXPECT_FALSE(memory.latched().any());
  memory.step(set_of({Fault::over_current}));
  EXPECT_EQ(memory.first(), Fault::over_current);
  EXPECT_EQ(memory.total(), 2U);
}

}  // namespace
}  // namespace sextant
