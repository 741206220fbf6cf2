#include "sextant/hil/shared_memory_link.hpp"

#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
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
  void leave(const LinkHeader& header, std::size_t bytes = sizeof(LinkMemory)) const {
    std::string content(bytes, '\0');
    content.replace(0, sizeof header, std::string(reinterpret_cast<const char*>(&header), sizeof header));
    std::ofstream{file(), std::ios::binary} << content;
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

TEST_F(SharedMemoryLinkTest, MemoryOfAnotherUserIsRefusedWithARemedy) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can become another user";
  const SharedMemoryLink plant{link.parameters, LinkRole::plant, period_ns};
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const bool is_another = setegid(65'534) == 0 && seteuid(65'534) == 0;
    const std::string sentence = refusal(LinkRole::drive);
    _exit(is_another && sentence.find("Permission denied; another user made it") != std::string::npos ? 0
                                                                                                      : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
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
