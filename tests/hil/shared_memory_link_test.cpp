#include "sextant/hil/shared_memory_link.hpp"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "hil/test_link.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t period_ns = 100'000;

class SharedMemoryLinkTest : public testing::Test {
 protected:
  [[nodiscard]] std::string refusal(LinkRole role, std::int64_t period = period_ns) const {
    try {
      const SharedMemoryLink refused{link.parameters, role, period};
    } catch (const std::runtime_error& problem) {
      return problem.what();
    }
    return "accepted";
  }

  /// What an earlier program has left behind.
  void leave(const LinkHeader& header, std::size_t bytes = sizeof(LinkMemory), mode_t mode = 0600) const {
    std::string content(bytes, '\0');
    content.replace(0, sizeof header, std::string(reinterpret_cast<const char*>(&header), sizeof header));
    std::ofstream{file(), std::ios::binary} << content;
    chmod(file().c_str(), mode);
  }

  /// Both sides refuse what lies there, in one sentence that names it and says what helps.
  void expect_refusal(const std::string& reason) const {
    for (const LinkRole role : {LinkRole::plant, LinkRole::drive}) {
      const std::string sentence = refusal(role);
      EXPECT_THAT(sentence, HasSubstr("hil.link: the shared memory " + file() + " " + reason));
      EXPECT_THAT(sentence, HasSubstr("remove it, or choose another name"));
      EXPECT_EQ(sentence.find('\n'), std::string::npos);
    }
  }

  [[nodiscard]] std::string file() const { return "/dev/shm" + link.path(); }

  test::TestLink link;
  LinkHeader good{link_magic, link_layout_version, sizeof(LinkMemory), period_ns, 0, 0};
};

TEST_F(SharedMemoryLinkTest, EitherSideMakesItAndTheLastOneRemovesIt) {
  for (const LinkRole first : {LinkRole::plant, LinkRole::drive}) {
    const LinkRole second = first == LinkRole::plant ? LinkRole::drive : LinkRole::plant;
    std::optional<SharedMemoryLink> one;
    std::optional<SharedMemoryLink> two;
    one.emplace(link.parameters, first, period_ns);
    EXPECT_FALSE(one->other_is_attached());
    two.emplace(link.parameters, second, period_ns);
    EXPECT_TRUE(one->other_is_attached());
    EXPECT_TRUE(two->other_is_attached());
    EXPECT_EQ(one->other().present.load(), 1U);
    one.reset();
    EXPECT_FALSE(two->other_is_attached());
    EXPECT_EQ(two->other().present.load(), 0U);
    EXPECT_TRUE(std::filesystem::exists(file()));
    two.reset();
    EXPECT_FALSE(std::filesystem::exists(file()));
  }
}

TEST_F(SharedMemoryLinkTest, BothSidesSeeTheSameMemory) {
  const SharedMemoryLink plant{link.parameters, LinkRole::plant, period_ns};
  const SharedMemoryLink drive{link.parameters, LinkRole::drive, period_ns};
  plant.memory().measurements.push({.sequence = 7, .u_dc = 530});
  MeasurementRecord record;
  ASSERT_TRUE(drive.memory().measurements.read(1, record));
  EXPECT_EQ(record.u_dc, 530.0);
  EXPECT_EQ(drive.memory().header.magic, link_magic);
  EXPECT_EQ(drive.memory().header.period_ns, period_ns);
}

TEST_F(SharedMemoryLinkTest, AnotherVersionIsRefusedInOneSentence) {
  good.layout_version = link_layout_version + 1;
  leave(good);
  const std::string sentence = refusal(LinkRole::drive);
  EXPECT_THAT(sentence, HasSubstr("layout version 2, this program has 1"));
  EXPECT_THAT(sentence, HasSubstr(file()));
  EXPECT_EQ(sentence.find('\n'), std::string::npos);
}

TEST_F(SharedMemoryLinkTest, ForeignMemoryIsRefused) {
  good.magic ^= 1;
  leave(good);
  EXPECT_THAT(refusal(LinkRole::plant), HasSubstr("is none of Sextant's"));
}

TEST_F(SharedMemoryLinkTest, WhatAStartThatWasKilledWhileAttachingHasLeftIsNew) {
  leave({});
  {
    const SharedMemoryLink plant{link.parameters, LinkRole::plant, period_ns};
    EXPECT_EQ(plant.memory().header.magic, link_magic);
    EXPECT_EQ(refusal(LinkRole::drive), "accepted");
  }
  leave({}, sizeof(LinkMemory) - 1);
  EXPECT_THAT(refusal(LinkRole::plant), HasSubstr("is none of Sextant's"));
}

TEST_F(SharedMemoryLinkTest, MemoryThatOtherUsersMayReachIsRefused) {
  for (const auto& [mode, text] : {std::pair{0666, "0666"}, std::pair{0640, "0640"}, std::pair{0604, "0604"},
                                   std::pair{0602, "0602"}, std::pair{0610, "0610"}}) {
    leave({}, sizeof(LinkMemory), static_cast<mode_t>(mode));
    expect_refusal(std::string{"may be reached by other users (mode "} + text + ")");
  }
  leave(good, sizeof(LinkMemory), 0666);
  expect_refusal("may be reached by other users (mode 0666)");
}

TEST_F(SharedMemoryLinkTest, WhatIsNoPlainFileIsRefused) {
  ASSERT_EQ(mkfifo(file().c_str(), 0600), 0);
  expect_refusal("is no regular file");
}

TEST_F(SharedMemoryLinkTest, ALinkToAnotherPlaceIsRefused) {
  const std::string elsewhere = file() + ".elsewhere";
  std::ofstream{elsewhere}.close();
  chmod(elsewhere.c_str(), 0600);
  std::filesystem::create_symlink(elsewhere, file());
  EXPECT_THAT(refusal(LinkRole::plant), HasSubstr(file() + " cannot be opened"));
  std::filesystem::remove(file());
  std::filesystem::create_hard_link(elsewhere, file());
  expect_refusal("has 2 names");
  std::filesystem::remove(elsewhere);
}

TEST_F(SharedMemoryLinkTest, MemoryOfAnotherUserIsRefusedToRootToo) {
  if (geteuid() != 0) GTEST_SKIP() << "NOT TESTED: only root can give a file to another user";
  leave({});
  ASSERT_EQ(chown(file().c_str(), 65'534, 65'534), 0);
  expect_refusal("belongs to another user (id 65534; this program runs as 0)");
}

TEST_F(SharedMemoryLinkTest, MemoryOfAnotherUserIsRefusedWithARemedy) {
  if (geteuid() != 0) GTEST_SKIP() << "NOT TESTED: only root can become another user";
  const SharedMemoryLink plant{link.parameters, LinkRole::plant, period_ns};
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const bool is_another = setegid(65'534) == 0 && seteuid(65'534) == 0;
    const std::string sentence = refusal(LinkRole::drive);
    const bool says_so =
        sentence.find("belongs to another user (id 0; this program runs as 65534)") != std::string::npos &&
        sentence.find("run both sides as one user") != std::string::npos;
    _exit(is_another && says_so ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

/// Holds the byte of the file that a side holds while it attaches or leaves; gives it up in the end.
class HeldAttachment {
 public:
  explicit HeldAttachment(const std::string& file) : file_{open(file.c_str(), O_RDWR | O_CLOEXEC)} {
    flock lock{};
    lock.l_type = F_WRLCK;
    lock.l_whence = SEEK_SET;
    lock.l_len = 1;
    holds_ = file_ >= 0 && fcntl(file_, F_OFD_SETLK, &lock) == 0;
  }
  HeldAttachment(const HeldAttachment&) = delete;
  HeldAttachment& operator=(const HeldAttachment&) = delete;
  ~HeldAttachment() { release(); }

  [[nodiscard]] bool holds() const { return holds_; }
  void release() {
    if (file_ >= 0) close(file_);
    file_ = -1;
  }

 private:
  int file_;
  bool holds_{false};
};

constexpr std::chrono::seconds far_longer_than_the_patience{30};

TEST_F(SharedMemoryLinkTest, ALockThatIsNeverGivenUpEndsTheStartWithASentence) {
  leave({});
  HeldAttachment held{file()};
  ASSERT_TRUE(held.holds());
  std::future<std::string> start =
      std::async(std::launch::async, [this] { return refusal(LinkRole::plant); });
  const bool ended = start.wait_for(far_longer_than_the_patience) == std::future_status::ready;
  held.release();
  EXPECT_TRUE(ended) << "it waits without a word";
  EXPECT_THAT(start.get(),
              HasSubstr("hil.link: the shared memory " + file() + " is locked by another program"));
}

TEST_F(SharedMemoryLinkTest, ALockThatIsGivenUpSoonIsWaitedFor) {
  leave({});
  HeldAttachment held{file()};
  ASSERT_TRUE(held.holds());
  std::future<std::string> start =
      std::async(std::launch::async, [this] { return refusal(LinkRole::plant); });
  EXPECT_EQ(start.wait_for(std::chrono::milliseconds{50}), std::future_status::timeout);
  held.release();
  EXPECT_EQ(start.get(), "accepted");
}

TEST_F(SharedMemoryLinkTest, ALockThatIsNeverGivenUpDoesNotKeepASideFromLeaving) {
  auto plant = std::make_unique<SharedMemoryLink>(link.parameters, LinkRole::plant, period_ns);
  HeldAttachment held{file()};
  ASSERT_TRUE(held.holds());
  std::future<void> end = std::async(std::launch::async, [&plant] { plant.reset(); });
  const bool ended = end.wait_for(far_longer_than_the_patience) == std::future_status::ready;
  held.release();
  end.get();
  EXPECT_TRUE(ended) << "it waits without a word";
}

TEST_F(SharedMemoryLinkTest, AnotherSizeIsRefused) {
  good.size_bytes += 64;
  leave(good);
  EXPECT_THAT(refusal(LinkRole::plant), HasSubstr("this program needs"));
  good.size_bytes -= 64;
  leave(good, sizeof(LinkMemory) - 1);
  EXPECT_THAT(refusal(LinkRole::plant), HasSubstr("this program needs"));
  leave(good, sizeof(LinkHeader));
  EXPECT_THAT(refusal(LinkRole::plant), HasSubstr("this program needs"));
}

TEST_F(SharedMemoryLinkTest, AnotherPeriodOrPacingOfALivingSideIsRefused) {
  const SharedMemoryLink plant{link.parameters, LinkRole::plant, period_ns};
  EXPECT_THAT(refusal(LinkRole::drive, 25'000), HasSubstr("a period of 100000 ns, this one with 25000 ns"));
  link.parameters.pacing = Pacing::lockstep;
  EXPECT_THAT(refusal(LinkRole::drive), HasSubstr("one side"));
  link.parameters.pacing = Pacing::real_time;
  EXPECT_EQ(refusal(LinkRole::drive), "accepted");
}

TEST_F(SharedMemoryLinkTest, WhatADeadRunHasLeftIsUsedAgainWithAnotherPeriod) {
  good.period_ns = 25'000;
  leave(good);
  const SharedMemoryLink plant{link.parameters, LinkRole::plant, period_ns};
  EXPECT_EQ(plant.memory().header.period_ns, period_ns);
}

TEST_F(SharedMemoryLinkTest, ARoleIsTakenOnce) {
  const SharedMemoryLink plant{link.parameters, LinkRole::plant, period_ns};
  EXPECT_THAT(refusal(LinkRole::plant), HasSubstr("already has a plant"));
  EXPECT_EQ(refusal(LinkRole::drive), "accepted");
}

TEST_F(SharedMemoryLinkTest, ANewStartIsANewGenerationAndItsGatesAreDisabled) {
  const SharedMemoryLink plant{link.parameters, LinkRole::plant, period_ns};
  std::uint32_t before = 0;
  for (int n = 0; n < 3; ++n) {
    const SharedMemoryLink drive{link.parameters, LinkRole::drive, period_ns};
    EXPECT_EQ(plant.memory().gate_enable.load(), 0U);
    EXPECT_GT(drive.generation(), before);
    before = drive.generation();
    plant.memory().gate_enable.store(drive.generation());
  }
  EXPECT_EQ(plant.memory().gate_enable.load(), 0U) << "leaving takes the line away";
}

TEST_F(SharedMemoryLinkTest, AKilledSideIsGoneAtOnceAndComesBack) {
  const SharedMemoryLink plant{link.parameters, LinkRole::plant, period_ns};
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const SharedMemoryLink drive{link.parameters, LinkRole::drive, period_ns};
    pause();
    _exit(0);
  }
  for (int n = 0; n < 20'000 && plant.memory().drive.present.load() == 0; ++n) usleep(1000);
  if (plant.memory().drive.present.load() == 0) {
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    FAIL() << "the other side did not attach within 20 s";
  }
  EXPECT_TRUE(plant.other_is_attached());
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_FALSE(plant.other_is_attached());
  EXPECT_EQ(plant.memory().drive.present.load(), 1U) << "it could not say that it leaves";
  const SharedMemoryLink drive{link.parameters, LinkRole::drive, period_ns};
  EXPECT_EQ(drive.generation(), 2U);
}

}  // namespace
}  // namespace sextant
