#include "sextant/realtime/thread_setup.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

namespace sextant {
namespace {

using ::testing::HasSubstr;

/// Runs f on a thread of its own, so that the test program's main thread keeps its scheduling.
template <class F>
void on_a_thread(F f) {
  std::thread{f}.join();
}

TEST(ThreadSetup, FifoIsInForceWhenGrantedAndExplainedWhenNot) {
  on_a_thread([] {
    const Grant grant = use_fifo_scheduling(10);
    int policy = 0;
    sched_param parameters{};
    ASSERT_EQ(pthread_getschedparam(pthread_self(), &policy, &parameters), 0);
    if (grant.granted) {
      EXPECT_EQ(policy, SCHED_FIFO);
      EXPECT_EQ(parameters.sched_priority, 10);
      EXPECT_TRUE(grant.sentence.empty());
    } else {
      EXPECT_EQ(policy, SCHED_OTHER);
      EXPECT_THAT(grant.sentence, HasSubstr("SCHED_FIFO priority 10 was refused"));
    }
  });
}

TEST(ThreadSetup, APriorityThatDoesNotExistIsRefused) {
  on_a_thread([] {
    const Grant grant = use_fifo_scheduling(1'000);
    EXPECT_FALSE(grant.granted);
    EXPECT_THAT(grant.sentence, HasSubstr("1000"));
  });
}

TEST(ThreadSetup, BindsToACpuThatIsAllowed) {
  on_a_thread([] {
    const int cpu = sched_getcpu();
    ASSERT_GE(cpu, 0);
    ASSERT_TRUE(bind_to_cpu(cpu).granted);
    cpu_set_t set;
    ASSERT_EQ(pthread_getaffinity_np(pthread_self(), sizeof set, &set), 0);
    EXPECT_EQ(CPU_COUNT(&set), 1);
    EXPECT_TRUE(CPU_ISSET(static_cast<std::size_t>(cpu), &set));
  });
}

TEST(ThreadSetup, ACpuThatDoesNotExistIsRefused) {
  on_a_thread([] {
    for (const int cpu : {-1, 1'000, 1'000'000}) {
      const Grant grant = bind_to_cpu(cpu);
      EXPECT_FALSE(grant.granted);
      EXPECT_THAT(grant.sentence, HasSubstr("CPU " + std::to_string(cpu)));
    }
  });
}

TEST(ThreadSetup, NamesTheThread) {
  on_a_thread([] {
    ASSERT_TRUE(name_thread("sextant-control").granted);
    std::array<char, 16> name{};
    ASSERT_EQ(pthread_getname_np(pthread_self(), name.data(), name.size()), 0);
    EXPECT_STREQ(name.data(), "sextant-control");
    const Grant grant = name_thread("a name beyond fifteen characters");
    EXPECT_FALSE(grant.granted);
    EXPECT_THAT(grant.sentence, HasSubstr("at most 15 characters"));
  });
}

TEST(ThreadSetup, ThrottlingIsReadFromTheKernel) {
  const std::string path = ::testing::TempDir() + "sextant_sched_rt_runtime_us";
  std::ofstream{path} << "950000\n";
  const Grant throttled = check_no_throttling(path);
  EXPECT_FALSE(throttled.granted);
  EXPECT_THAT(throttled.sentence, HasSubstr("holds 950000"));
  std::ofstream{path} << "-1\n";
  EXPECT_TRUE(check_no_throttling(path).granted);
  std::filesystem::remove(path);
  const Grant unknown = check_no_throttling(path);
  EXPECT_FALSE(unknown.granted);
  EXPECT_THAT(unknown.sentence, HasSubstr("cannot be read"));
}

TEST(ThreadSetup, EveryRefusalHasItsSentence) {
  on_a_thread([] {
    RealtimeParameters parameters;
    parameters.lock_memory = false;  // it would lock the whole test program
    parameters.cpu = 1'000;
    const std::vector<std::string> refusals = set_up_control_thread(parameters).refusals;
    EXPECT_THAT(refusals, ::testing::Contains(HasSubstr("CPU 1000")));
    EXPECT_THAT(refusals, ::testing::Each(::testing::Not(::testing::IsEmpty())));
  });
}

TEST(ThreadSetup, ParametersAreChecked) {
  EXPECT_EQ(RealtimeParameters{}.validate(), nullptr);
  const auto with = [](auto member, int value) {
    RealtimeParameters p;
    p.*member = value;
    return p;
  };
  EXPECT_NE(with(&RealtimeParameters::wake_every_periods, 0).validate(), nullptr);
  EXPECT_NE(with(&RealtimeParameters::priority, 0).validate(), nullptr);
  EXPECT_NE(with(&RealtimeParameters::priority, 99).validate(), nullptr);
  EXPECT_NE(with(&RealtimeParameters::cpu, -2).validate(), nullptr);
}

}  // namespace
}  // namespace sextant
