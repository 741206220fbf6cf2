#include "sextant/comms/e2e_profile11.hpp"

#include <cstddef>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr std::uint16_t data_id = 0x123;

e2e::Data protected_zeros(std::uint8_t counter) {
  e2e::Data data{};
  e2e::protect(data_id, counter, data);
  return data;
}

TEST(E2eProfile11, ProtectsThePublishedVectors) {
  EXPECT_EQ(protected_zeros(0), (e2e::Data{0x2A, 0x10, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(protected_zeros(1), (e2e::Data{0x77, 0x11, 0, 0, 0, 0, 0, 0}));
  static_assert(e2e::crc(data_id, e2e::Data{0, 0x10, 0, 0, 0, 0, 0, 0}) == 0x2A);
}

TEST(E2eProfile11, DetectsEverySingleAndDoubleBitFlip) {
  constexpr unsigned seed = 20240607;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 20; ++round) {
    e2e::Data good{};
    for (auto& byte : good) byte = static_cast<std::uint8_t>(random());
    e2e::protect(data_id, static_cast<std::uint8_t>(round % 15), good);
    for (std::size_t i = 0; i < 64; ++i) {
      for (std::size_t j = i; j < 64; ++j) {
        e2e::Data bad = good;
        bad[i / 8] = static_cast<std::uint8_t>(bad[i / 8] ^ (1U << (i % 8)));
        if (j != i) bad[j / 8] = static_cast<std::uint8_t>(bad[j / 8] ^ (1U << (j % 8)));
        ASSERT_EQ(E2eChecker(data_id).check(bad), E2eResult::wrong_crc) << "bits " << i << " and " << j;
      }
    }
  }
}

TEST(E2eProfile11, RefusesEveryOtherDataIdOfTheSameHighNibble) {
  for (unsigned other = 0x100; other < 0x200; ++other) {
    if (other == data_id) continue;
    e2e::Data data{};
    e2e::protect(static_cast<std::uint16_t>(other), 0, data);
    EXPECT_EQ(E2eChecker(data_id).check(data), E2eResult::wrong_crc) << std::hex << other;
  }
}

TEST(E2eProfile11, RefusesAnotherDataIdNibbleUnderAGoodCrc) {
  e2e::Data data{0, 0x20, 0, 0, 0, 0, 0, 0};
  data[0] = e2e::crc(data_id, data);
  EXPECT_EQ(E2eChecker(data_id).check(data), E2eResult::wrong_data_id);
}

TEST(E2eProfile11, ProtectorCountsFrom0To14AndWraps) {
  E2eProtector protector(data_id);
  for (unsigned i = 0; i < 40; ++i) {
    e2e::Data data{};
    protector.protect(data);
    EXPECT_EQ(data[1] & 0x0F, int(i % 15));
    EXPECT_EQ(data[0], e2e::crc(data_id, data));
  }
}

struct CounterStep {
  std::uint8_t counter;
  E2eResult expected;
};

void expect_results(const std::vector<CounterStep>& steps) {
  E2eChecker checker(data_id);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(int(checker.check(protected_zeros(steps[i].counter))), int(steps[i].expected)) << "step " << i;
  }
}

TEST(E2eProfile11, EvaluatesCountersByTheirStep) {
  expect_results({{0, E2eResult::ok},
                  {1, E2eResult::ok},
                  {1, E2eResult::repeated},
                  {3, E2eResult::ok_some_lost},
                  {6, E2eResult::ok_some_lost},
                  {10, E2eResult::wrong_sequence},
                  {11, E2eResult::ok},
                  {14, E2eResult::ok_some_lost},
                  {0, E2eResult::ok},
                  {14, E2eResult::wrong_sequence},
                  {2, E2eResult::ok_some_lost}});
}

TEST(E2eProfile11, RefusesCounter15AndDoesNotFollowIt) {
  expect_results(
      {{0, E2eResult::ok}, {15, E2eResult::invalid_counter}, {1, E2eResult::ok}, {2, E2eResult::ok}});
}

TEST(E2eProfile11, DoesNotFollowTheCounterOfACorruptedFrame) {
  E2eChecker checker(data_id);
  EXPECT_EQ(checker.check(protected_zeros(0)), E2eResult::ok);
  e2e::Data bad = protected_zeros(9);
  bad[7] ^= 1;
  EXPECT_EQ(checker.check(bad), E2eResult::wrong_crc);
  EXPECT_EQ(checker.check(protected_zeros(1)), E2eResult::ok);
}

TEST(E2eProfile11, StreamBecomesValidAtTheThirdGoodFrame) {
  E2eChecker checker(data_id);
  EXPECT_EQ(checker.state(), E2eState::no_data);
  checker.check(protected_zeros(0));
  EXPECT_EQ(checker.state(), E2eState::init);
  checker.check(protected_zeros(1));
  EXPECT_EQ(checker.state(), E2eState::init);
  checker.check(protected_zeros(2));
  EXPECT_EQ(checker.state(), E2eState::valid);
  checker.reset();
  EXPECT_EQ(checker.state(), E2eState::no_data);
}

TEST(E2eProfile11, ValidatesItsParameters) {
  EXPECT_EQ(E2eChecker::Parameters{}.validate(), nullptr);
  EXPECT_NE((E2eChecker::Parameters{.max_delta_counter = 0}).validate(), nullptr);
  EXPECT_NE((E2eChecker::Parameters{.max_delta_counter = 15}).validate(), nullptr);
  EXPECT_NE((E2eChecker::Parameters{.state_machine = {.window = 0}}).validate(), nullptr);
  EXPECT_NE((E2eChecker::Parameters{.state_machine = {.window = 33}}).validate(), nullptr);
  EXPECT_NE((E2eChecker::Parameters{.state_machine = {.window = 4}}).validate(), nullptr);
}

}  // namespace
}  // namespace sextant
