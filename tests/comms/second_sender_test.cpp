#include "sextant/comms/second_sender.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <random>

#include <gtest/gtest.h>

#include "comms/command_frames.hpp"
#include "sextant/comms/command_receiver.hpp"

namespace sextant {
namespace {

constexpr std::int64_t ms = 1'000'000;

/// A vehicle control unit that sends each 10 ms.
struct Sender {
  std::int64_t next_ns{0};
  std::uint8_t counter{0};
  double torque{15.0};

  CanFrame send() {
    const CanFrame frame = testing::command_frame(counter, torque, next_ns);
    counter = std::uint8_t((counter + 1) % 15);
    next_ns += 10 * ms;
    return frame;
  }
};

struct SecondSenderOnTheBus : ::testing::Test {
  /// Frames of one sender until then; true where a second one is seen.
  bool one(std::int64_t until_ns) {
    while (first.next_ns < until_ns) receiver.on_frame(first.send());
    return receiver.command().second_sender;
  }
  /// Frames of both until then; the time at which the second one is seen.
  std::optional<std::int64_t> both(Sender& second, std::int64_t until_ns) {
    while (std::min(first.next_ns, second.next_ns) < until_ns) {
      Sender& earlier = first.next_ns <= second.next_ns ? first : second;
      const CanFrame frame = earlier.send();
      receiver.on_frame(frame);
      if (receiver.command().second_sender) return frame.received_ns;
    }
    return std::nullopt;
  }

  CommandReceiver receiver{};
  Sender first{};
};

TEST_F(SecondSenderOnTheBus, IsSeenWithin50MsWhateverItsCounterAndPhase) {
  for (std::uint8_t ahead = 0; ahead < 15; ++ahead) {
    for (const std::int64_t phase_us : {10, 1000, 5000, 9990}) {
      SCOPED_TRACE(::testing::Message() << int(ahead) << " ahead, " << phase_us << " us");
      receiver = CommandReceiver{};
      first = {};
      EXPECT_FALSE(one(200 * ms));
      const std::int64_t begin_ns = first.next_ns + phase_us * 1000 - 10 * ms;
      Sender second{
          .next_ns = begin_ns, .counter = std::uint8_t((first.counter + ahead) % 15), .torque = 14.0};
      const std::optional<std::int64_t> seen_ns = both(second, 300 * ms);
      ASSERT_TRUE(seen_ns);
      EXPECT_LE(*seen_ns - begin_ns, 50 * ms);
    }
  }
}

// It sends a frame of its own, `ahead` of the counter that it has just heard, behind every n-th frame: the
// first sender's frame of that counter is a repetition then, or out of order.
TEST_F(SecondSenderOnTheBus, ThatHidesBehindTheFirstIsSeenAtItsSecondFrame) {
  for (int every = 1; every <= 15; ++every) {
    for (std::uint8_t ahead = 1; ahead <= 2; ++ahead) {
      for (const std::int64_t behind_us : {100, 1000, 5000, 9900}) {
        SCOPED_TRACE(::testing::Message()
                     << "every " << every << ", " << int(ahead) << " ahead, " << behind_us);
        receiver = CommandReceiver{};
        first = {};
        EXPECT_FALSE(one(200 * ms));
        const std::int64_t begin_ns = first.next_ns;
        std::optional<std::int64_t> seen_ns;
        for (int k = 0; k < 60 && !seen_ns; ++k) {
          const CanFrame heard = first.send();
          receiver.on_frame(heard);
          if (receiver.command().second_sender) seen_ns = heard.received_ns;
          if (k % every != 0) continue;
          Sender hidden{.next_ns = heard.received_ns + behind_us * 1000,
                        .counter = std::uint8_t((first.counter + ahead - 1) % 15),
                        .torque = 100.0};
          receiver.on_frame(hidden.send());
        }
        ASSERT_TRUE(seen_ns);
        EXPECT_LE(*seen_ns - begin_ns, std::max(50, 10 * (every + 2)) * ms);
      }
    }
  }
}

// A disable in the name of the sender is as much evidence as a torque.
TEST_F(SecondSenderOnTheBus, ThatDisablesIsSeenWithin50Ms) {
  EXPECT_FALSE(one(200 * ms));
  const std::int64_t begin_ns = first.next_ns;
  while (!receiver.command().second_sender && first.next_ns < begin_ns + 60 * ms) {
    const CanFrame heard = first.send();
    receiver.on_frame(heard);
    receiver.on_frame(testing::command_frame(first.counter, 0.0, heard.received_ns + ms, false));
  }
  EXPECT_TRUE(receiver.command().second_sender);
  EXPECT_LE(first.next_ns - begin_ns, 50 * ms);
}

// Every delay and loss of one sender: what is queued comes in one burst, with torque that changes.
TEST_F(SecondSenderOnTheBus, IsNoneWhereOneSendersFramesAreLateAndLost) {
  std::mt19937 random{20'261};
  SCOPED_TRACE("seed 20261");
  std::uniform_real_distribution<double> share{0.0, 1.0};
  std::int64_t until_ns = 0;
  for (int k = 0; k < 200'000; ++k) {
    first.torque = 100.0 * share(random);
    if (share(random) < 0.01) until_ns = first.next_ns + std::int64_t(share(random) * 400 * double(ms));
    CanFrame frame = first.send();
    frame.received_ns = std::max(frame.received_ns, until_ns) + std::int64_t(share(random) * 4 * double(ms));
    until_ns = frame.received_ns > until_ns ? frame.received_ns : until_ns;
    if (share(random) < 0.1) continue;  // lost
    receiver.on_frame(frame);
    if (share(random) < 0.05) receiver.on_frame(frame);  // by a gateway
    ASSERT_FALSE(receiver.command().second_sender) << k;
  }
}

TEST_F(SecondSenderOnTheBus, CountsUntil200MsAfterItsLastFrames) {
  one(200 * ms);
  Sender second{.next_ns = 205 * ms, .counter = 12, .torque = 14.0};
  ASSERT_TRUE(both(second, 300 * ms));
  EXPECT_TRUE(one(400 * ms));
  EXPECT_FALSE(one(550 * ms));
}

TEST_F(SecondSenderOnTheBus, IsNoneWhereOneSenderIsLateFrozenLossyOrRepeated) {
  // A pause, and what was queued in it at once.
  one(200 * ms);
  for (int k = 0; k < 5; ++k) {
    CanFrame frame = first.send();
    frame.received_ns = 260 * ms;
    receiver.on_frame(frame);
  }
  EXPECT_FALSE(receiver.command().second_sender);
  EXPECT_FALSE(one(500 * ms));
  // A frozen counter with changing torque.
  for (int k = 0; k < 50; ++k) {
    first.counter = 3;
    first.torque = 10.0 + k;
    receiver.on_frame(first.send());
    EXPECT_FALSE(receiver.command().second_sender);
  }
  // A counter that jumps with each frame.
  for (int k = 0; k < 50; ++k) {
    first.counter = std::uint8_t((first.counter + 6) % 15);
    receiver.on_frame(first.send());
    EXPECT_FALSE(receiver.command().second_sender);
  }
  // A gateway that sends each frame twice.
  for (int k = 0; k < 50; ++k) {
    const CanFrame frame = first.send();
    receiver.on_frame(frame);
    receiver.on_frame(frame);
    EXPECT_FALSE(receiver.command().second_sender);
  }
}

TEST_F(SecondSenderOnTheBus, FramesWithAWrongCrcAreNoSender) {
  one(200 * ms);
  Sender second{.next_ns = 205 * ms, .counter = 12, .torque = 14.0};
  while (first.next_ns < 400 * ms) {
    receiver.on_frame(first.send());
    CanFrame bad = second.send();
    bad.data[0] ^= 1U;
    receiver.on_frame(bad);
  }
  EXPECT_FALSE(receiver.command().second_sender);
}

TEST(SecondSender, RefusesWhatCannotBeCounted) {
  using Parameters = SecondSender::Parameters;
  EXPECT_EQ(Parameters{}.validate(), nullptr);
  EXPECT_NE((Parameters{.window_ns = 0}.validate()), nullptr);
  EXPECT_NE((Parameters{.frames = 1}.validate()), nullptr);
  EXPECT_NE((Parameters{.frames = 33}.validate()), nullptr);
  EXPECT_NE((Parameters{.out_of_order = 0}.validate()), nullptr);
  EXPECT_NE((Parameters{.out_of_order = 9}.validate()), nullptr);
  EXPECT_NE((Parameters{.cycle_ns = 0}.validate()), nullptr);
  EXPECT_NE((Parameters{.hold_ns = -1}.validate()), nullptr);
}

}  // namespace
}  // namespace sextant
