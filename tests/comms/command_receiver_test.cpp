#include "sextant/comms/command_receiver.hpp"

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "comms/command_frames.hpp"

namespace sextant {
namespace {

using testing::command_frame;
using testing::protect;

constexpr std::int64_t ms = 1'000'000;

/// A receiver whose stream is VALID: counters 0 to 2 have come, with 5 N·m at 0, 10 and 20 ms.
class CommandReceiverTest : public ::testing::Test {
 protected:
  void SetUp() override {
    for (std::uint8_t i = 0; i < 3; ++i) receiver_.on_frame(command_frame(i, 5.0, i * 10 * ms));
    ASSERT_EQ(receiver_.command().e2e, E2eState::valid);
    ASSERT_EQ(receiver_.command().sequence, 1U);
  }

  /// Sends a frame that must be rejected for this reason and change nothing but counters.
  void expect_rejected(const CanFrame& frame, FrameVerdict reason) {
    SCOPED_TRACE(to_string(reason));
    const TorqueCommand<double> before = receiver_.command();
    const std::uint64_t count = receiver_.count(reason);
    EXPECT_EQ(std::string(to_string(receiver_.on_frame(frame))), to_string(reason));
    const TorqueCommand<double>& after = receiver_.command();
    EXPECT_EQ(receiver_.count(reason), count + 1);
    EXPECT_EQ(after.rejected, before.rejected + 1);
    EXPECT_EQ(after.torque, before.torque);
    EXPECT_EQ(after.torque_limit, before.torque_limit);
    EXPECT_EQ(after.enable, before.enable);
    EXPECT_EQ(after.fault_reset, before.fault_reset);
    EXPECT_EQ(after.received_ns, before.received_ns);
    EXPECT_EQ(after.sequence, before.sequence);
    EXPECT_EQ(after.counter, before.counter);
    EXPECT_EQ(after.bus_off, before.bus_off);
  }

  void expect_accepted(std::uint8_t counter, double torque = 7.0) {
    SCOPED_TRACE(int(counter));
    EXPECT_EQ(receiver_.on_frame(command_frame(counter, torque, 30 * ms)), FrameVerdict::accepted);
    EXPECT_NEAR(receiver_.command().torque, torque, 1e-9);
  }

  CommandReceiver receiver_;
};

TEST(CommandReceiver, TakesNothingBeforeTheStreamIsValid) {
  CommandReceiver receiver;
  EXPECT_EQ(receiver.command().e2e, E2eState::no_data);
  EXPECT_EQ(receiver.on_frame(command_frame(0, 5.0)), FrameVerdict::not_valid_yet);
  EXPECT_EQ(receiver.on_frame(command_frame(1, 5.0)), FrameVerdict::not_valid_yet);
  EXPECT_EQ(receiver.command().rejected, 2U);
  EXPECT_EQ(receiver.command().sequence, 0U);
  EXPECT_FALSE(receiver.command().enable);
  EXPECT_EQ(receiver.on_frame(command_frame(2, 5.0)), FrameVerdict::accepted);
  EXPECT_EQ(receiver.command().sequence, 1U);
}

TEST_F(CommandReceiverTest, TakesOverAGoodFrame) {
  CanFrame frame = encode(TorqueCommand<>{-42.5, 60.0, true, true}).frame;
  protect(frame, command_data_id(), 3);
  frame.received_ns = 30 * ms;
  EXPECT_EQ(receiver_.on_frame(frame), FrameVerdict::accepted);
  const TorqueCommand<double>& c = receiver_.command();
  EXPECT_NEAR(c.torque, -42.5, 1e-9);
  EXPECT_NEAR(c.torque_limit, 60.0, 1e-9);
  EXPECT_TRUE(c.enable);
  EXPECT_TRUE(c.fault_reset);
  EXPECT_EQ(c.received_ns, 30 * ms);
  EXPECT_EQ(c.counter, 3);
  EXPECT_EQ(c.sequence, 2U);
  EXPECT_EQ(c.rejected, 2U) << "those before the stream was valid";
}

TEST_F(CommandReceiverTest, OneOrTwoLostFramesAreNoMatter) {
  expect_accepted(4);
  expect_accepted(7);
  expect_accepted(8);
}

TEST_F(CommandReceiverTest, OneBadCrcIsHeldAndCounted) {
  CanFrame bad = command_frame(3, 9.0, 30 * ms);
  bad.data[3] ^= 0x10;
  expect_rejected(bad, FrameVerdict::wrong_crc);
  EXPECT_EQ(receiver_.command().e2e, E2eState::valid);
  expect_accepted(4);
}

TEST_F(CommandReceiverTest, AFrozenCounterIsHeldWithoutRefreshingTheAge) {
  for (int i = 0; i < 30; ++i) {
    expect_rejected(command_frame(2, 9.0, (30 + 10 * i) * ms), FrameVerdict::repeated);
  }
  EXPECT_EQ(receiver_.command().received_ns, 20 * ms);
  EXPECT_EQ(receiver_.command().e2e, E2eState::valid);
}

TEST_F(CommandReceiverTest, ACounterJumpIsHeldAndThenFollowed) {
  expect_rejected(command_frame(9, 9.0, 30 * ms), FrameVerdict::wrong_sequence);
  expect_accepted(10);
}

TEST_F(CommandReceiverTest, AnotherDataIdIsHeld) {
  CanFrame low = command_frame(3, 9.0, 30 * ms);
  protect(low, 0x111, 3);
  expect_rejected(low, FrameVerdict::wrong_crc);
  CanFrame nibble = command_frame(3, 9.0, 30 * ms);
  nibble.data[1] = 0x23;
  e2e::Data data{};
  std::copy_n(nibble.data.begin(), data.size(), data.begin());
  nibble.data[0] = e2e::crc(command_data_id(), data);
  expect_rejected(nibble, FrameVerdict::wrong_data_id);
  expect_accepted(3);
}

TEST_F(CommandReceiverTest, Counter15IsHeld) {
  expect_rejected(command_frame(15, 9.0, 30 * ms), FrameVerdict::invalid_counter);
  EXPECT_EQ(receiver_.command().e2e, E2eState::valid);
  expect_accepted(3);
}

TEST_F(CommandReceiverTest, WrongKindsOfFrameAreHeldAndDoNotTouchTheStream) {
  for (const std::uint8_t length : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{7}}) {
    CanFrame frame = command_frame(3, 9.0, 30 * ms);
    frame.length = length;
    expect_rejected(frame, FrameVerdict::wrong_length);
  }
  CanFrame remote = command_frame(3, 9.0, 30 * ms);
  remote.rtr = true;
  expect_rejected(remote, FrameVerdict::remote_frame);
  CanFrame extended = command_frame(3, 9.0, 30 * ms);
  extended.extended = true;
  expect_rejected(extended, FrameVerdict::extended_alias);
  CanFrame fd = command_frame(3, 9.0, 30 * ms);
  fd.fd = true;
  expect_rejected(fd, FrameVerdict::fd_alias);
  expect_accepted(3);
}

TEST_F(CommandReceiverTest, OutOfRangeIsBlockedAndItsStreakCounted) {
  CanFrame frame = command_frame(3, 250.0, 30 * ms);
  frame.data[3] = 0x7F;  // about 326 N·m
  for (std::uint8_t i = 0; i < 3; ++i) {
    protect(frame, command_data_id(), static_cast<std::uint8_t>(3 + i));
    expect_rejected(frame, FrameVerdict::out_of_range);
    EXPECT_EQ(receiver_.command().out_of_range, i + 1U);
  }
  expect_accepted(6);
  EXPECT_EQ(receiver_.command().out_of_range, 0U);
}

/// A disable whose torque and limit are these words. [raw]
CanFrame disable_with(std::uint16_t torque, std::uint16_t limit, std::uint8_t counter,
                      bool fault_reset = false) {
  CanFrame frame = encode(TorqueCommand<>{.fault_reset = fault_reset}).frame;
  for (unsigned i = 0; i < 2; ++i) {
    frame.data[2 + i] = std::uint8_t(torque >> 8 * i);
    frame.data[4 + i] = std::uint8_t(limit >> 8 * i);
  }
  protect(frame, command_data_id(), counter);
  frame.received_ns = (10 * counter) * ms;
  return frame;
}

TEST_F(CommandReceiverTest, ADisableIsOneWhateverItsTorqueIs) {
  std::uint8_t counter = 3;
  for (const unsigned torque : {0x8000U, 0x7FFFU, 0x61A9U, 0x0000U}) {
    for (const unsigned limit : {0xFFFFU, 0x61A9U, 0x0000U}) {
      SCOPED_TRACE(torque * 65'536U + limit);
      EXPECT_EQ(receiver_.on_frame(disable_with(std::uint16_t(torque), std::uint16_t(limit), counter)),
                FrameVerdict::accepted);
      const TorqueCommand<double>& c = receiver_.command();
      EXPECT_FALSE(c.enable);
      EXPECT_EQ(c.torque, 0.0);
      EXPECT_EQ(c.torque_limit, 0.0);
      EXPECT_EQ(c.received_ns, (10 * counter) * ms) << "the age is that of the disable";
      EXPECT_EQ(c.out_of_range, 0U);
      EXPECT_EQ(c.counter, counter);
      counter = std::uint8_t(counter + 1);
    }
  }
}

TEST_F(CommandReceiverTest, ADisableEndsARowOfFramesOutOfRange) {
  CanFrame wild = command_frame(3, 250.0, 30 * ms);
  wild.data[3] = 0x7F;
  protect(wild, command_data_id(), 3);
  expect_rejected(wild, FrameVerdict::out_of_range);
  EXPECT_EQ(receiver_.on_frame(disable_with(0x8000, 0xFFFF, 4)), FrameVerdict::accepted);
  EXPECT_EQ(receiver_.command().out_of_range, 0U);
}

TEST_F(CommandReceiverTest, CountsDisablesAndThoseThatReset) {
  EXPECT_EQ(receiver_.command().disables, 0U);
  EXPECT_EQ(receiver_.on_frame(command_frame(3, 5.0, 30 * ms, false)), FrameVerdict::accepted);
  expect_accepted(4);
  EXPECT_EQ(receiver_.command().disables, 1U) << "an enable does not take it back";
  EXPECT_EQ(receiver_.command().resets, 0U);
  EXPECT_EQ(receiver_.on_frame(disable_with(0x8000, 0, 5, true)), FrameVerdict::accepted);
  expect_accepted(6);
  EXPECT_EQ(receiver_.command().disables, 2U);
  EXPECT_EQ(receiver_.command().resets, 1U);
  expect_rejected(command_frame(6, 5.0, 30 * ms, false), FrameVerdict::repeated);
  EXPECT_EQ(receiver_.command().disables, 2U) << "only what was accepted counts";
}

/// A frame of the bus: a good command most of the time, else one with anything about it changed.
CanFrame random_frame(std::mt19937_64& dice, std::uint8_t& counter) {
  CanFrame frame = command_frame(counter, double(dice() % 400) - 200.0, 0, dice() % 2 == 0);
  counter = std::uint8_t((counter + 1) % 15);
  switch (dice() % 24) {
    case 0:
      frame.data[dice() % 8] ^= std::uint8_t(1U << dice() % 8);
      break;
    case 1:
      frame.id = std::uint32_t(dice() % 0x800);
      break;
    case 2:
      frame.length = std::uint8_t(dice() % 9);
      break;
    case 3:
      frame.rtr = true;
      break;
    case 4:
      frame.extended = true;
      break;
    case 5:
      frame.fd = true;
      break;
    case 6:
      frame.error = true;
      frame.id = std::uint32_t(dice() % 0x200);
      break;
    case 7:
      counter = std::uint8_t(dice() % 15);
      break;
    case 8:
      for (std::size_t i = 2; i < 6; ++i) frame.data[i] = std::uint8_t(dice());
      protect(frame, command_data_id(), std::uint8_t(dice() % 16));
      break;
    case 9:
      for (std::size_t i = 0; i < 8; ++i) frame.data[i] = std::uint8_t(dice());
      break;
    default:
      break;
  }
  return frame;
}

TEST(CommandReceiverProperty, EveryFrameIsAcceptedOrRejectedForOneCauseOrNoCommand) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 dice{seed};
    CommandReceiver receiver;
    std::uint64_t commands = 0;
    std::uint8_t counter = 0;
    constexpr std::uint64_t frames = 10'000;
    for (std::uint64_t n = 1; n <= frames; ++n) {
      const CanFrame frame = random_frame(dice, counter);
      const std::uint64_t accepted = receiver.count(FrameVerdict::accepted);
      const FrameVerdict verdict = receiver.on_frame(frame);
      if (!frame.error && frame.id == command_id()) ++commands;
      ASSERT_EQ(receiver.count(FrameVerdict::accepted) - accepted,
                verdict == FrameVerdict::accepted ? 1U : 0U);
      ASSERT_EQ(receiver.count(FrameVerdict::accepted) + receiver.command().rejected, commands)
          << "frame " << n << ": " << to_string(verdict);
      ASSERT_EQ(receiver.command().sequence, receiver.count(FrameVerdict::accepted));
    }
    std::uint64_t verdicts = 0;
    for (std::size_t v = 0; v < frame_verdict_count; ++v) {
      verdicts += receiver.count(static_cast<FrameVerdict>(v));
    }
    EXPECT_EQ(verdicts, frames);
    std::uint64_t rejected = 0;
    for (std::size_t v = 0; v < frame_verdict_count; ++v) {
      const auto verdict = static_cast<FrameVerdict>(v);
      if (is_rejection(verdict)) rejected += receiver.count(verdict);
    }
    EXPECT_EQ(rejected, receiver.rejected());
    EXPECT_EQ(receiver.count(FrameVerdict::accepted) + rejected, commands);
    EXPECT_GT(receiver.count(FrameVerdict::not_valid_yet), 100U) << "the case was met";
  }
}

TEST(CommandReceiver, TwoDrivesOnOneBusEachTakeTheirOwnCommands) {
  const IdentifierOffset none{};
  for (const IdentifierOffset moved : {IdentifierOffset{32}, IdentifierOffset{256}, IdentifierOffset{1728}}) {
    SCOPED_TRACE(moved.value);
    CommandReceiver first;
    CommandReceiver second{{.identifier_offset = moved}};
    for (std::uint8_t n = 0; n < 10; ++n) {
      for (const CanFrame& frame :
           {command_frame(n, 5.0, 0, true, none), command_frame(n, -7.0, 0, true, moved)}) {
        first.on_frame(frame);
        second.on_frame(frame);
      }
    }
    EXPECT_NEAR(first.command().torque, 5.0, 1e-9);
    EXPECT_NEAR(second.command().torque, -7.0, 1e-9);
    for (const CommandReceiver* receiver : {&first, &second}) {
      EXPECT_EQ(receiver->count(FrameVerdict::accepted), 8U) << "all but those before the stream was valid";
      EXPECT_EQ(receiver->count(FrameVerdict::unrelated), 10U);
      EXPECT_EQ(receiver->command().e2e, E2eState::valid);
    }
  }
}

TEST(CommandReceiver, AFrameOfOneDriveUnderTheIdentifierOfAnotherIsRejected) {
  for (const IdentifierOffset moved : {IdentifierOffset{32}, IdentifierOffset{256}, IdentifierOffset{1728}}) {
    SCOPED_TRACE(moved.value);
    CommandReceiver receiver{{.identifier_offset = moved}};
    for (std::uint8_t n = 0; n < 3; ++n) receiver.on_frame(command_frame(n, 5.0, 0, true, moved));
    ASSERT_EQ(receiver.count(FrameVerdict::accepted), 1U);
    CanFrame replayed = command_frame(3, 100.0);
    replayed.id = command_id(moved);
    // Data ids 256 apart have one CRC; the nibble tells them apart.
    EXPECT_EQ(receiver.on_frame(replayed),
              moved.value == 256 ? FrameVerdict::wrong_data_id : FrameVerdict::wrong_crc);
    EXPECT_NEAR(receiver.command().torque, 5.0, 1e-9);
  }
}

TEST(CommandReceiver, AnotherDriveIsOneWithTheSameOffset) {
  const IdentifierOffset moved{64};
  for (const IdentifierOffset own : {IdentifierOffset{}, moved}) {
    CommandReceiver receiver{{.identifier_offset = own}};
    for (std::uint8_t n = 0; n < 5; ++n) {
      CanFrame frame = encode(TorqueStatus{.command_counter = {}}).frame;
      frame.id = moved.id(frame.id);
      protect(frame, torque_status_data_id(moved), n);
      receiver.on_frame(frame);
    }
    EXPECT_EQ(receiver.count(FrameVerdict::other_drive), own.value == moved.value ? 3U : 0U);
  }
}

TEST(CommandReceiver, RefusesAnOffsetThatIsNoBlock) {
  EXPECT_EQ(CommandReceiver::Parameters{}.validate(), nullptr);
  EXPECT_NE((CommandReceiver::Parameters{.identifier_offset = {16}}.validate()), nullptr);
}

TEST_F(CommandReceiverTest, AValidStreamOfStatusIsAnotherDrive) {
  const auto status = [](std::uint8_t counter) {
    CanFrame frame = encode(TorqueStatus{.command_counter = {}}).frame;
    protect(frame, torque_status_data_id(), counter);
    return frame;
  };
  const std::uint64_t rejected = receiver_.rejected();
  EXPECT_EQ(receiver_.on_frame(status(0)), FrameVerdict::unrelated);
  EXPECT_EQ(receiver_.on_frame(status(1)), FrameVerdict::unrelated);
  EXPECT_EQ(receiver_.on_frame(status(2)), FrameVerdict::other_drive);
  EXPECT_EQ(receiver_.on_frame(status(2)), FrameVerdict::unrelated) << "a repetition proves nobody";
  EXPECT_EQ(receiver_.on_frame(status(3)), FrameVerdict::other_drive);
  EXPECT_EQ(receiver_.rejected(), rejected) << "they are no commands";
  expect_accepted(3);
}

TEST_F(CommandReceiverTest, ABurstOfBadCrcsInvalidatesAndTheStreamRecovers) {
  for (std::uint8_t i = 0; i < 3; ++i) {
    EXPECT_EQ(receiver_.command().e2e, E2eState::valid);
    CanFrame bad = command_frame(static_cast<std::uint8_t>(3 + i), 9.0, 30 * ms);
    bad.data[0] ^= 0xFF;
    expect_rejected(bad, FrameVerdict::wrong_crc);
  }
  EXPECT_EQ(receiver_.command().e2e, E2eState::invalid);
  // The stream goes on at counter 6, four after the last good one: out of sequence once. The last error
  // leaves the window of ten with the tenth frame after it.
  expect_rejected(command_frame(6, 9.0, 60 * ms), FrameVerdict::wrong_sequence);
  for (unsigned i = 7; i < 15; ++i) {
    EXPECT_EQ(receiver_.on_frame(command_frame(static_cast<std::uint8_t>(i), 9.0, 70 * ms)),
              FrameVerdict::not_valid_yet);
    EXPECT_EQ(receiver_.command().e2e, E2eState::invalid);
    EXPECT_NEAR(receiver_.command().torque, 5.0, 1e-9);
  }
  expect_accepted(0, 9.0);
  EXPECT_EQ(receiver_.command().e2e, E2eState::valid);
}

TEST_F(CommandReceiverTest, OtherFramesOfTheBusDoNotCount) {
  const TorqueCommand<double> before = receiver_.command();
  for (const std::uint32_t id : {0x000U, 0x10FU, 0x111U, 0x120U, 0x124U, 0x7FFU}) {
    CanFrame frame = command_frame(3, 9.0, 30 * ms);
    frame.id = id;
    EXPECT_EQ(receiver_.on_frame(frame), FrameVerdict::unrelated);
  }
  EXPECT_EQ(receiver_.command().rejected, before.rejected);
  EXPECT_EQ(receiver_.command().sequence, before.sequence);
  EXPECT_EQ(receiver_.count(FrameVerdict::unrelated), 6U);
}

TEST_F(CommandReceiverTest, BusOffIsShownUntilACommandProvesTheBus) {
  const CanFrame bus_off{.id = can_error_bus_off, .error = true, .length = 8, .received_ns = 25 * ms};
  EXPECT_EQ(receiver_.on_frame(bus_off), FrameVerdict::error_frame);
  EXPECT_TRUE(receiver_.command().bus_off);
  EXPECT_EQ(receiver_.command().rejected, 2U) << "those before the stream was valid";
  receiver_.on_frame(command_frame(3, 5.0, 30 * ms));  // too soon for the control thread to have seen it
  EXPECT_TRUE(receiver_.command().bus_off);
  receiver_.on_frame(command_frame(4, 5.0, 45 * ms));
  EXPECT_FALSE(receiver_.command().bus_off);
}

TEST_F(CommandReceiverTest, ABusOffThatIsReportedAgainAndAgainIsOne) {
  for (int i = 0; i < 20; ++i) {
    receiver_.on_frame(
        {.id = can_error_bus_off, .error = true, .length = 8, .received_ns = (25 + 5 * i) * ms});
    receiver_.on_frame(command_frame(std::uint8_t((3 + i) % 15), 5.0, (27 + 5 * i) * ms));
    EXPECT_TRUE(receiver_.command().bus_off) << i;
  }
  receiver_.on_frame(command_frame(8, 5.0, 139 * ms));
  EXPECT_TRUE(receiver_.command().bus_off);
  receiver_.on_frame(command_frame(9, 5.0, 140 * ms));
  EXPECT_FALSE(receiver_.command().bus_off);
}

TEST_F(CommandReceiverTest, OtherErrorFramesAreNotBusOff) {
  const CanFrame warning{.id = 0x4, .error = true, .length = 8, .received_ns = 25 * ms};
  EXPECT_EQ(receiver_.on_frame(warning), FrameVerdict::error_frame);
  EXPECT_FALSE(receiver_.command().bus_off);
}

}  // namespace
}  // namespace sextant
