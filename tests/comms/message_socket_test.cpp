#include "sextant/comms/message_socket.hpp"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/comms/telemetry_messages.hpp"

namespace sextant {
namespace {

using namespace std::chrono_literals;

class MessageSocketTest : public ::testing::Test {
 protected:
  std::optional<std::span<const std::byte>> receive(MessageSocket& socket) { return socket.receive(buffer_); }

  std::pair<MessageSocket, MessageSocket> ends_{MessageSocket::pair()};
  MessageSocket& one_{ends_.first};
  MessageSocket& other_{ends_.second};

 private:
  std::array<std::byte, 1024> buffer_{};
};

TEST_F(MessageSocketTest, MessagesArriveWholeAndInOrder) {
  EXPECT_FALSE(receive(other_));
  for (std::uint64_t n = 0; n < 10; ++n) {
    ASSERT_EQ(one_.send_struct(IntervalMessage{.sequence = n, .dropped = 3, .record = {}}),
              MessageSend::sent);
  }
  for (std::uint64_t n = 0; n < 10; ++n) {
    ASSERT_TRUE(other_.wait(5s));
    const auto message = receive(other_);
    ASSERT_TRUE(message);
    EXPECT_EQ(kind_of(*message), TelemetryMessageKind::interval);
    EXPECT_EQ(content_of<IntervalMessage>(*message).value().sequence, n);
  }
  EXPECT_FALSE(receive(other_));
}

TEST_F(MessageSocketTest, BytesArriveAsTheyAre) {
  const std::vector<std::byte> sent(100, std::byte{7});
  ASSERT_EQ(one_.send(sent), MessageSend::sent);
  const auto message = receive(other_).value();
  EXPECT_EQ(std::vector<std::byte>(message.begin(), message.end()), sent);
}

TEST_F(MessageSocketTest, AFullOneRefusesAndNeverWaits) {
  int sent = 0;
  while (one_.send_struct(IntervalMessage{}) == MessageSend::sent) ASSERT_LT(++sent, 1'000'000);
  EXPECT_GT(sent, 100);
  EXPECT_EQ(one_.send_struct(IntervalMessage{}), MessageSend::full);
  ASSERT_TRUE(receive(other_));
  EXPECT_EQ(one_.send_struct(IntervalMessage{}), MessageSend::sent);
}

TEST_F(MessageSocketTest, TheEndIsSeenAfterWhatWasSent) {
  ASSERT_EQ(one_.send_struct(AnswerMessage{}), MessageSend::sent);
  one_.finish();
  EXPECT_FALSE(receive(other_).value().empty());
  EXPECT_TRUE(receive(other_).value().empty());
  ASSERT_EQ(other_.send_struct(AnswerMessage{}), MessageSend::sent) << "the other way is still open";
  EXPECT_FALSE(receive(one_).value().empty());
  {
    const MessageSocket gone = std::move(other_);
  }
  EXPECT_TRUE(receive(one_).value().empty());
  EXPECT_EQ(one_.send_struct(AnswerMessage{}), MessageSend::closed);
}

TEST_F(MessageSocketTest, OneOfSeveralIsEnoughToWaitFor) {
  auto [near, far] = MessageSocket::pair();
  const std::array<const MessageSocket*, 2> both{&other_, &far};
  EXPECT_FALSE(MessageSocket::wait_any(both, 1ms));
  ASSERT_EQ(near.send_struct(AnswerMessage{}), MessageSend::sent);
  EXPECT_TRUE(MessageSocket::wait_any(both, 5s));
  EXPECT_FALSE(receive(other_));
  EXPECT_TRUE(receive(far));
  one_.finish();
  EXPECT_TRUE(MessageSocket::wait_any(both, 5s)) << "the end of one too";
}

TEST(TelemetryMessages, TheReasonOfAStateGoesWithIt) {
  const std::string reason(200, 'x');
  const StateMessage message{7, {.t_ns = 5, .first_fault = Fault::watchdog, .reason = reason}};
  const auto copy = content_of<StateMessage>(std::as_bytes(std::span{&message, 1})).value();
  EXPECT_EQ(copy.sequence, 7U);
  EXPECT_EQ(copy.sample().t_ns, 5);
  EXPECT_EQ(copy.sample().first_fault, Fault::watchdog);
  EXPECT_EQ(copy.sample().reason, std::string(127, 'x'));
  EXPECT_FALSE(content_of<StateMessage>(std::as_bytes(std::span{&message, 1}).first(8)));
}

}  // namespace
}  // namespace sextant
