#include "sextant/realtime/thread_setup.hpp"

#include <array>
#include <barrier>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

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

TEST(ThreadSetup, DeadlineSchedulingIsInForceWhenGrantedAndExplainedWhenNot) {
  on_a_thread([] {
    const Grant grant = use_deadline_scheduling(100'000, 1'000'000);
    if (grant.granted) {
      EXPECT_EQ(sched_getscheduler(0), 6) << "SCHED_DEADLINE";
      EXPECT_TRUE(grant.sentence.empty());
    } else {
      EXPECT_EQ(sched_getscheduler(0), SCHED_OTHER);
      EXPECT_THAT(grant.sentence, HasSubstr("SCHED_DEADLINE with 100 us in each 1000 us was refused"));
    }
  });
}

TEST(ThreadSetup, DeadlinesThatCannotBeAreRefused) {
  const auto refusal_of = [](std::int64_t runtime_ns, std::int64_t period_ns) {
    std::string sentence;
    on_a_thread([&] { sentence = use_deadline_scheduling(runtime_ns, period_ns).sentence; });
    return sentence;
  };
  EXPECT_THAT(refusal_of(2'000'000, 1'000'000), HasSubstr("from 1.024 us to the wake period"));
  EXPECT_THAT(refusal_of(100, 1'000'000), HasSubstr("from 1.024 us"));
}

TEST(ThreadSetup, RequiredRightsThatAreRefusedAreAllNamed) {
  RealtimeParameters p;
  RightsReport refused;
  refused.refusals = {"no priority", "no memory"};
  EXPECT_NO_THROW(require_rights(p, refused)) << "they are not required";
  p.required = true;
  EXPECT_NO_THROW(require_rights(p, {}));
  try {
    require_rights(p, refused);
    FAIL() << "refused rights are taken for granted ones";
  } catch (const std::runtime_error& problem) {
    EXPECT_STREQ(problem.what(),
                 "realtime.required is set, and not everything is granted: no priority; no memory");
  }
}

TEST(ThreadSetup, ASpinningFifoThreadOnTheOnlyCpuIsRefused) {
  RealtimeParameters p;
  p.policy = SchedulingPolicy::fifo;
  p.wait.mode = WaitMode::spin;
  const RightsReport granted{.real_time_scheduling = true};
  EXPECT_THROW(require_room_for_spinning(p, granted, 1), std::runtime_error);
  EXPECT_NO_THROW(require_room_for_spinning(p, granted, 2));
  EXPECT_NO_THROW(require_room_for_spinning(p, {}, 1)) << "the scheduler shares the CPU out";
  p.wait.mode = WaitMode::sleep;
  EXPECT_NO_THROW(require_room_for_spinning(p, granted, 1));
}

TEST(ThreadSetup, TheCpusThatTheControlThreadMayUseCountAsWell) {
  on_a_thread([] {
    const int own = sched_getcpu();
    ASSERT_TRUE(bind_to_cpu(own).granted);
    EXPECT_EQ(usable_cpus(), 1);
    EXPECT_EQ(usable_cpus(own), 1);
    EXPECT_EQ(usable_cpus(own + 1), 2);
  });
}

TEST(ThreadSetup, ACpuThatWasRefusedIsNoRoomForSpinning) {
  on_a_thread([] {
    ASSERT_TRUE(bind_to_cpu(sched_getcpu()).granted);
    RealtimeParameters p;
    p.wait.mode = WaitMode::spin;
    p.cpu = 1'000;
    p.lock_memory = false;
    p.policy = SchedulingPolicy::other;
    RightsReport rights = set_up_control_thread(p, 1'000'000);
    EXPECT_EQ(rights.cpu, -1);
    p.policy = SchedulingPolicy::fifo;
    rights.real_time_scheduling = true;
    EXPECT_THROW(require_room_for_spinning(p, rights), std::runtime_error);
  });
}

TEST(ThreadSetup, ACpuThatWasGrantedCountsAsRoomForSpinning) {
  on_a_thread([] {
    const int own = sched_getcpu();
    RealtimeParameters p;
    p.cpu = own;
    p.lock_memory = false;
    p.policy = SchedulingPolicy::other;
    EXPECT_EQ(set_up_control_thread(p, 1'000'000).cpu, own);
  });
}

TEST(ThreadSetup, MoreDeadlineThreadsThanCpusAreRefused) {
  std::ifstream throttling{"/proc/sys/kernel/sched_rt_runtime_us"};
  long runtime_us = 0;
  if (throttling >> runtime_us && runtime_us < 0)
    GTEST_SKIP() << "the kernel admits any number: no throttling";
  const unsigned count = std::thread::hardware_concurrency() + 1;
  std::vector<Grant> grants(count);
  std::barrier all_have_asked{std::ptrdiff_t{count}};
  std::vector<std::thread> threads;
  for (Grant& grant : grants) {
    threads.emplace_back([&] {
      grant = use_deadline_scheduling(1'000'000, 1'000'000);
      all_have_asked.arrive_and_wait();
    });
  }
  for (std::thread& thread : threads) thread.join();
  const auto may_not = ::testing::Contains(
      ::testing::Field(&Grant::sentence, HasSubstr(std::generic_category().message(EPERM))));
  if (getuid() == 0 && ::testing::Value(grants, may_not)) {
    GTEST_SKIP() << "root may not ask for SCHED_DEADLINE here";
  }
  if (getuid() == 0) {
    EXPECT_THAT(grants, ::testing::Contains(
                            ::testing::Field(&Grant::sentence, HasSubstr("the CPUs have no room for it"))));
  } else {
    EXPECT_THAT(grants, ::testing::Each(::testing::Field(&Grant::granted, false)));
  }
}

TEST(ThreadSetup, DeadlineSchedulingAndOneCpuExcludeEachOther) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "one CPU is every CPU";
  on_a_thread([] {
    ASSERT_TRUE(bind_to_cpu(sched_getcpu()).granted);
    EXPECT_THAT(use_deadline_scheduling(100'000, 1'000'000).sentence,
                HasSubstr("let the process use every CPU"));
  });
}

TEST(ThreadSetup, ThePolicyThatIsAskedForIsTheOneInForce) {
  for (const auto& [policy, number] :
       {std::pair{SchedulingPolicy::other, SCHED_OTHER}, std::pair{SchedulingPolicy::fifo, SCHED_FIFO},
        std::pair{SchedulingPolicy::deadline, 6}}) {
    SCOPED_TRACE(to_string(policy));
    on_a_thread([&] {
      RealtimeParameters parameters;
      parameters.lock_memory = false;
      parameters.policy = policy;
      const RightsReport rights = set_up_control_thread(parameters, 1'000'000);
      if (policy == SchedulingPolicy::other) {
        EXPECT_FALSE(rights.real_time_scheduling);
        EXPECT_THAT(rights.refusals, ::testing::IsEmpty());
      }
      EXPECT_EQ(sched_getscheduler(0), rights.real_time_scheduling ? number : SCHED_OTHER);
    });
  }
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

TEST(ThreadSetup, StacksOfLaterThreadsAreSmallAndLargeEnough) {
  constexpr std::size_t used_before_the_first_period = 256 * 1024;
  reserve_little_memory();
  on_a_thread([] {
    pthread_attr_t attributes;
    ASSERT_EQ(pthread_getattr_np(pthread_self(), &attributes), 0);
    std::size_t bytes = 0;
    EXPECT_EQ(pthread_attr_getstacksize(&attributes, &bytes), 0);
    pthread_attr_destroy(&attributes);
    EXPECT_LE(bytes, std::size_t{1024} * 1024);
    EXPECT_GE(bytes, 2 * used_before_the_first_period);
    prefault_stack();
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

int cpus_of_this_thread(cpu_set_t& set) {
  CPU_ZERO(&set);
  EXPECT_EQ(pthread_getaffinity_np(pthread_self(), sizeof set, &set), 0);
  return CPU_COUNT(&set);
}

TEST(ThreadSetup, ACpuIsKeptFreeOfTheThreadAndOfThoseThatItStarts) {
  on_a_thread([] {
    cpu_set_t before;
    const int count = cpus_of_this_thread(before);
    if (count < 2) GTEST_SKIP() << "it needs two CPUs";
    int cpu = 0;
    while (!CPU_ISSET(static_cast<std::size_t>(cpu), &before)) ++cpu;
    EXPECT_TRUE(keep_off_cpu(cpu).granted);
    std::thread{[&] {
      cpu_set_t after;
      EXPECT_EQ(cpus_of_this_thread(after), count - 1);
      EXPECT_FALSE(CPU_ISSET(static_cast<std::size_t>(cpu), &after));
    }}.join();
    EXPECT_TRUE(bind_to_cpu(cpu).granted) << "the one thread that is to have it";
  });
}

TEST(ThreadSetup, TheLastCpuIsNotKeptFree) {
  on_a_thread([] {
    cpu_set_t set;
    for (int left = cpus_of_this_thread(set), cpu = 0; left > 0; ++cpu) {
      if (!CPU_ISSET(static_cast<std::size_t>(cpu), &set)) continue;
      const Grant grant = keep_off_cpu(cpu);
      EXPECT_EQ(grant.granted, --left > 0) << cpu;
      EXPECT_THAT(grant.sentence, HasSubstr(left == 0 ? "no processor is left but CPU" : ""));
    }
    EXPECT_EQ(cpus_of_this_thread(set), 1);
  });
}

TEST(ThreadSetup, NoCpuToKeepFreeChangesNothing) {
  on_a_thread([] {
    cpu_set_t set;
    const int before = cpus_of_this_thread(set);
    EXPECT_TRUE(keep_off_cpu(-1).granted);
    EXPECT_EQ(cpus_of_this_thread(set), before);
  });
}

TEST(ThreadSetup, EveryRefusalHasItsSentence) {
  on_a_thread([] {
    RealtimeParameters parameters;
    parameters.lock_memory = false;  // it would lock the whole test program
    parameters.cpu = 1'000;
    const std::vector<std::string> refusals = set_up_control_thread(parameters, 1'000'000).refusals;
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
  RealtimeParameters p;
  p.wait.spin_margin_ns = -1;
  EXPECT_NE(p.validate(), nullptr);
  p = {};
  p.wait.tick_lead_ns = -1;
  EXPECT_NE(p.validate(), nullptr);
  p = {};
  p.gap_limit_ns = 0;
  EXPECT_NE(p.validate(), nullptr);
  p = {};
  p.policy = SchedulingPolicy::deadline;
  EXPECT_EQ(p.validate(), nullptr);
  p.wait.mode = WaitMode::spin;
  EXPECT_THAT(p.validate(), HasSubstr("uses up the time"));
  p.wait.mode = WaitMode::sleep;
  p.cpu = 0;
  EXPECT_THAT(p.validate(), HasSubstr("exclude each other"));
  p.cpu = -1;
  p.deadline_runtime_ns = 1'000;
  EXPECT_NE(p.validate(), nullptr);
}

TEST(ThreadSetup, HybridWaitingHasToSleepAndADeadlineThreadsTimeToFit) {
  RealtimeParameters p;
  p.wait.spin_margin_ns = 50'000;
  for (const WaitMode mode : {WaitMode::sleep, WaitMode::spin}) {
    p.wait.mode = mode;
    EXPECT_EQ(p.validate(25'000), nullptr) << "the margin is not in force";
  }
  p.wait.mode = WaitMode::hybrid;
  for (const SchedulingPolicy policy :
       {SchedulingPolicy::fifo, SchedulingPolicy::other, SchedulingPolicy::deadline}) {
    p.policy = policy;
    p.deadline_runtime_ns = 20'000;
    EXPECT_THAT(p.validate(25'000), HasSubstr("spin_margin_us is too long"));
    EXPECT_THAT(p.validate(50'000), HasSubstr("never sleeps"));
    EXPECT_EQ(p.validate(50'001), nullptr);
  }
  p.deadline_runtime_ns = 50'002;
  EXPECT_THAT(p.validate(50'001), HasSubstr("deadline_runtime_us is too long"));
}

}  // namespace
}  // namespace sextant
