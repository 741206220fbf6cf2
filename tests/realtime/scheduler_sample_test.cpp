#include "sextant/realtime/scheduler_sample.hpp"

#include <filesystem>

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "sextant/realtime/monotonic_clock.hpp"
#include "support/text_files.hpp"

namespace sextant {
namespace {

/// A /proc with one thread, number 42.
class FakeProc {
 public:
  FakeProc() {
    std::filesystem::create_directories(root() + "/self/task/42");
    write("self/task/42/schedstat", "111 222 333\n");
    write("self/task/42/status",
          "Name:\tsextant\nvoluntary_ctxt_switches:\t4\nnonvoluntary_ctxt_switches:\t5\n");
    write("self/task/42/stat", "42 (a b) c) R 1 2 3 4 5 6 77 8 99 10 11\n");
    write("stat", "cpu  1 2 3 4 5 6 7 8 9 10\ncpu0 1 2 3 4 5 6 7 9 9 10\n");
  }
  void write(const std::string& name, const std::string& text) const { (void)files_.write(name, text); }
  [[nodiscard]] std::string root() const { return std::filesystem::path{files_.path("x")}.parent_path(); }

 private:
  TextFiles files_{};
};

TEST(SchedulerSampler, ReadsWhatTheKernelWrites) {
  const FakeProc proc;
  const std::int64_t before_ns = now_ns();
  const SchedulerSample sample = SchedulerSampler{42, proc.root()}.sample();
  ASSERT_TRUE(sample.valid);
  EXPECT_GE(sample.t_ns, before_ns);
  EXPECT_LE(sample.t_ns, now_ns());
  EXPECT_EQ(sample.run_delay_ns, 222);
  EXPECT_EQ(sample.voluntary_switches, 4U);
  EXPECT_EQ(sample.involuntary_switches, 5U);
  EXPECT_EQ(sample.minor_faults, 77U);
  EXPECT_EQ(sample.major_faults, 99U);
  EXPECT_EQ(sample.steal_ns, 8 * (ns_per_s / sysconf(_SC_CLK_TCK)));
}

TEST(SchedulerSampler, SaysWhenSomethingIsMissing) {
  for (const char* const file :
       {"self/task/42/schedstat", "self/task/42/status", "self/task/42/stat", "stat"}) {
    const FakeProc proc;
    proc.write(file, "nothing of use\n");
    EXPECT_FALSE((SchedulerSampler{42, proc.root()}.sample().valid)) << file;
  }
  EXPECT_FALSE(SchedulerSampler{43}.sample().valid) << "no such thread";
}

TEST(SchedulerSampler, CountsThePageFaultsOfThisThread) {
  constexpr std::size_t pages = 32;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const SchedulerSampler sampler{gettid()};
  void* const memory =
      mmap(nullptr, pages * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  ASSERT_EQ(madvise(memory, pages * page, MADV_NOHUGEPAGE), 0);
  const SchedulerSample before = sampler.sample();
  for (std::size_t i = 0; i < pages; ++i) static_cast<volatile char*>(memory)[i * page] = 1;
  const SchedulerSample growth = sampler.sample().since(before);
  munmap(memory, pages * page);
  ASSERT_TRUE(growth.valid);
  EXPECT_GE(growth.minor_faults, pages);
  EXPECT_LT(growth.minor_faults, pages + 1000);
}

TEST(SchedulerSample, ExplainsAGapByAsMuchWaitingForAProcessorOrAsMuchStolenTime) {
  SchedulerSample growth{.run_delay_ns = 99, .involuntary_switches = 1, .valid = true};
  EXPECT_FALSE(growth.explains(100));
  growth.run_delay_ns = 100;
  EXPECT_TRUE(growth.explains(100));
  growth.involuntary_switches = 0;
  EXPECT_FALSE(growth.explains(100)) << "nobody took the processor away";
  EXPECT_FALSE((SchedulerSample{.steal_ns = 99, .valid = true}.explains(100)));
  EXPECT_TRUE((SchedulerSample{.steal_ns = 100, .valid = true}.explains(100)));
  EXPECT_FALSE((SchedulerSample{.involuntary_switches = 9, .minor_faults = 9, .valid = true}.explains(100)));
  EXPECT_FALSE((SchedulerSample{.run_delay_ns = 100, .involuntary_switches = 1}.explains(100)))
      << "not valid";
}

TEST(SchedulerSample, WhatExplainedOneGapExplainsNoOther) {
  SchedulerSample growth{.run_delay_ns = 150, .steal_ns = 250, .involuntary_switches = 9, .valid = true};
  for (int n = 0; n < 3; ++n) {
    ASSERT_TRUE(growth.explains(100)) << n;
    growth.spend(100);
  }
  EXPECT_FALSE(growth.explains(100));
  EXPECT_EQ(growth.run_delay_ns, 50);
  EXPECT_EQ(growth.steal_ns, 50);
  EXPECT_EQ(growth.involuntary_switches, 8U) << "one gap by a switch, two by theft";
}

TEST(SchedulerSample, ASwitchThatMadeOneGapMadeNoOther) {
  SchedulerSample growth{.run_delay_ns = 900, .involuntary_switches = 1, .valid = true};
  growth.spend(100);
  EXPECT_FALSE(growth.explains(100));
}

TEST(SchedulerSample, WhatIsLeftOverIsAddedAndCutMemberByMember) {
  const SchedulerSample earlier{1, 2, 3, 4, 5, 6, 7, false};
  const SchedulerSample growth{100, 10, 20, 30, 40, 50, 60, true};
  const SchedulerSample both = growth.and_left_over(earlier);
  EXPECT_EQ(both.t_ns, 100);
  EXPECT_EQ(both.run_delay_ns, 12);
  EXPECT_EQ(both.steal_ns, 23);
  EXPECT_EQ(both.voluntary_switches, 34U);
  EXPECT_EQ(both.involuntary_switches, 45U);
  EXPECT_EQ(both.minor_faults, 56U);
  EXPECT_EQ(both.major_faults, 67U);
  EXPECT_TRUE(both.valid);
  const SchedulerSample cut = both.at_most(growth);
  EXPECT_EQ(cut.t_ns, 100);
  EXPECT_EQ(cut.run_delay_ns, 10);
  EXPECT_EQ(cut.steal_ns, 20);
  EXPECT_EQ(cut.voluntary_switches, 30U);
  EXPECT_EQ(cut.involuntary_switches, 40U);
  EXPECT_EQ(cut.minor_faults, 50U);
  EXPECT_EQ(cut.major_faults, 60U);
  EXPECT_EQ(growth.at_most(both).steal_ns, 20);
  EXPECT_TRUE(cut.valid);
}

TEST(SchedulerSample, GrowthIsTakenMemberByMember) {
  const SchedulerSample before{1, 2, 3, 4, 5, 6, 7, true};
  const SchedulerSample now{100, 200, 300, 400, 500, 600, 700, true};
  const SchedulerSample growth = now.since(before);
  EXPECT_EQ(growth.t_ns, 100);
  EXPECT_EQ(growth.run_delay_ns, 198);
  EXPECT_EQ(growth.steal_ns, 297);
  EXPECT_EQ(growth.voluntary_switches, 396U);
  EXPECT_EQ(growth.involuntary_switches, 495U);
  EXPECT_EQ(growth.minor_faults, 594U);
  EXPECT_EQ(growth.major_faults, 693U);
  EXPECT_TRUE(growth.valid);
}

}  // namespace
}  // namespace sextant
