#include "ecu/threads/named_thread.hpp"

#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <pthread.h>

#include "ecu/eventually.hpp"
#include "ecu/fake_can_bus.hpp"
#include "ecu/threads/housekeeping_thread.hpp"
#include "ecu/threads/receive_thread.hpp"
#include "ecu/threads/transmit_thread.hpp"
#include "ecu/threads/watchdog_thread.hpp"

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
TEST(NamedThread, EveryThreadOfTheDriveGetsItsName) {
  SharedState shared{25'000, 40};
  test::FakeCanBus bus;
  ReceiveThread receive{bus, shared};
  TransmitThread transmit{bus, shared};
  WatchdogThread watchdog{shared};
  HousekeepingThread housekeeping{shared};
  receive.start();
  transmit.start();
  watchdog.start();
  housekeeping.start();
  for (const char* name : {"sextant-can-rx", "sextant-can-tx", "sextant-wdog", "sextant-house"}) {
    EXPECT_TRUE(test::eventually([name] { return thread_names().contains(name); })) << name;
  }
  shared.stopped.store(true);
  receive.join();
  transmit.join();
  watchdog.join();
  housekeeping.join();
}

}  // namespace
}  // namespace sextant::ecu
