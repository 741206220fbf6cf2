#include "ecu/threads/named_thread.hpp"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <pthread.h>

#include "ecu/eventually.hpp"
#include "ecu/fake_can_bus.hpp"
#include "ecu/threads/polled_thread.hpp"
#include "ecu/threads/receive_thread.hpp"

namespace sextant::ecu {
namespace {

/// The names of this process's threads.
std::set<std::string> thread_names() {
  std::set<std::string> names;
  std::error_code gone;  // a thread may end while it is looked at
  for (const auto& task : std::filesystem::directory_iterator{"/proc/self/task", gone}) {
    std::string name;
    std::ifstream file{task.path() / "comm"};
    if (std::getline(file, name)) names.insert(name);
  }
  return names;
}

TEST(NamedThread, RunsItsFunctionUnderItsName) {
  std::string name;
  NamedThread worker{"sextant-test"};
  worker.start([&name] {
    char text[16]{};
    pthread_getname_np(pthread_self(), text, sizeof(text));
    name = text;
  });
  worker.join();
  worker.join();
  EXPECT_EQ(name, "sextant-test");
}

TEST(NamedThread, MayBeJoinedWithoutAStart) {
  NamedThread worker{"sextant-test"};
  worker.join();
}

// Names beyond the kernel's 15 characters are refused, and the thread is not to be found.
TEST(NamedThread, TheReceiveThreadGetsItsName) {
  SharedState shared{25'000, 40};
  test::FakeCanBus bus;
  ReceiveTask task{shared};
  ReceiveThread receive{bus, {&task}, shared.stopped};
  receive.start();
  EXPECT_TRUE(test::eventually([] { return thread_names().contains("sextant-can-rx"); }));
  shared.stopped.store(true);
  receive.join();
}

TEST(PolledThread, BeginsPollsUntilItIsOverAndEnds) {
  std::atomic<bool> is_over{false};
  std::atomic<int> polls{0};
  std::string course;
  PolledThread polled{"sextant-polled1", is_over};
  polled.start({.begin = [&] { course += "begin "; },
                .poll =
                    [&] {
                      if (++polls == 1) course += "poll ";
                      return std::chrono::milliseconds{1};
                    },
                .end = [&] { course += "end"; }});
  EXPECT_TRUE(test::eventually([&] { return polls.load() >= 3; }));
  EXPECT_TRUE(thread_names().contains("sextant-polled1"));
  is_over.store(true);
  polled.join();
  polled.join();
  EXPECT_EQ(course, "begin poll end");
}

TEST(PolledThread, ThatIsOverBeforeItsStartBeginsAndEnds) {
  const std::atomic<bool> is_over{true};
  std::string course;
  PolledThread polled{"sextant-polled2", is_over};
  polled.start({.begin = [&] { course += "begin "; },
                .poll =
                    [&] {
                      course += "poll ";
                      return std::chrono::milliseconds{1};
                    },
                .end = [&] { course += "end"; }});
  polled.join();
  EXPECT_EQ(course, "begin end");
}

}  // namespace
}  // namespace sextant::ecu
