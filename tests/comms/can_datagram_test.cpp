#include "can_datagram.hpp"

#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sextant {
namespace {

/// Datagrams as python-can 4.6 writes them.
constexpr std::string_view classic_frame =
    "8ba974696d657374616d70cb3ff8000000000000ae6172626974726174696f6e5f6964cd0110ae69735f657874656e6465645f69"
    "64"
    "c2af69735f72656d6f74655f6672616d65c2ae69735f6572726f725f6672616d65c2a76368616e6e656cc0a3646c6308a4646174"
    "61"
    "c4080102030405060708a569735f6664c2ae626974726174655f737769746368c2b56572726f725f73746174655f696e64696361"
    "74"
    "6f72c2";
constexpr std::string_view extended_remote_frame =
    "8ba974696d657374616d7000ae6172626974726174696f6e5f6964ce18ff1234ae69735f657874656e6465645f6964c3af69735f"
    "72"
    "656d6f74655f6672616d65c3ae69735f6572726f725f6672616d65c2a76368616e6e656cc0a3646c6303a464617461c400a56973"
    "5f"
    "6664c2ae626974726174655f737769746368c2b56572726f725f73746174655f696e64696361746f72c2";
constexpr std::string_view fd_frame =
    "8ba974696d657374616d7000ae6172626974726174696f6e5f6964cd0110ae69735f657874656e6465645f6964c2af69735f7265"
    "6d"
    "6f74655f6672616d65c2ae69735f6572726f725f6672616d65c2a76368616e6e656cc0a3646c630ca464617461c40c0001020304"
    "05"
    "060708090a0ba569735f6664c3ae626974726174655f737769746368c3b56572726f725f73746174655f696e64696361746f72c"
    "2";

std::vector<char> bytes_of(std::string_view hex) {
  std::vector<char> bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes.push_back(static_cast<char>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
  }
  return bytes;
}

CanFrame some_frame() {
  CanFrame frame{.id = 0x110, .length = 8};
  for (std::uint8_t i = 0; i < 8; ++i) frame.data[i] = static_cast<std::uint8_t>(i + 1);
  return frame;
}

TEST(CanDatagram, WritesTheBytesThatPythonCanWrites) {
  const CanDatagram datagram = pack_datagram(some_frame(), 1.5);
  const std::vector<char> expected = bytes_of(classic_frame);
  EXPECT_EQ(std::vector<char>(datagram.bytes.data(), datagram.bytes.data() + datagram.length), expected);
}

TEST(CanDatagram, ReadsWhatPythonCanWrites) {
  const auto classic = unpack_datagram(bytes_of(classic_frame));
  ASSERT_TRUE(classic);
  EXPECT_EQ(classic->id, 0x110U);
  EXPECT_EQ(classic->length, 8);
  EXPECT_EQ(classic->data, some_frame().data);
  EXPECT_FALSE(classic->extended || classic->rtr || classic->error || classic->fd);

  const auto remote = unpack_datagram(bytes_of(extended_remote_frame));
  ASSERT_TRUE(remote);
  EXPECT_EQ(remote->id, 0x18FF1234U);
  EXPECT_TRUE(remote->extended && remote->rtr);
  EXPECT_EQ(remote->length, 3);

  const auto fd = unpack_datagram(bytes_of(fd_frame));
  ASSERT_TRUE(fd);
  EXPECT_TRUE(fd->fd);
  EXPECT_EQ(fd->length, 12);
  EXPECT_EQ(fd->data[11], 11);
}

TEST(CanDatagram, ReturnsEveryKindOfFrame) {
  std::vector<CanFrame> frames(5, some_frame());
  frames[1].extended = true;
  frames[1].id = 0x1FFFFFFF;
  frames[2].rtr = true;
  frames[2].data = {};
  frames[3].error = true;
  frames[3].id = can_error_bus_off;
  frames[4].fd = true;
  frames[4].length = 64;
  for (const CanFrame& frame : frames) {
    const CanDatagram datagram = pack_datagram(frame, 0.0);
    const auto back = unpack_datagram({datagram.bytes.data(), datagram.length});
    ASSERT_TRUE(back);
    EXPECT_EQ(back->id, frame.id);
    EXPECT_EQ(back->extended, frame.extended);
    EXPECT_EQ(back->rtr, frame.rtr);
    EXPECT_EQ(back->error, frame.error);
    EXPECT_EQ(back->fd, frame.fd);
    EXPECT_EQ(back->length, frame.length);
    EXPECT_EQ(back->data, frame.data);
  }
}

TEST(CanDatagram, RefusesEveryTruncation) {
  const std::vector<char> whole = bytes_of(classic_frame);
  for (std::size_t n = 0; n < whole.size(); ++n) {
    EXPECT_FALSE(unpack_datagram(std::span(whole).first(n))) << n;
  }
}

TEST(CanDatagram, RefusesWhatIsNoCanFrame) {
  for (const char* const hex : {"c0", "90", "80", "dfffffffff", "ddffffffff", "a3646c63", "81a3646c6308",
                                "81ae6172626974726174696f6e5f6964ff"}) {
    EXPECT_FALSE(unpack_datagram(bytes_of(hex))) << hex;
  }
}

TEST(CanDatagram, SurvivesRandomAndMutatedBytes) {
  constexpr unsigned seed = 7;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (int i = 0; i < 50'000; ++i) {
    std::vector<char> bytes = bytes_of(i % 2 == 0 ? classic_frame : fd_frame);
    for (int k = 0; k < 1 + i % 4; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
    const auto frame = unpack_datagram(bytes);
    if (!frame) continue;
    EXPECT_LE(frame->length, frame->fd ? 64 : 8);
    EXPECT_LE(frame->id, 0x1FFFFFFFU);
  }
}

}  // namespace
}  // namespace sextant
