#include "sextant/comms/can_bus.hpp"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "comms/refusal.hpp"

namespace sextant {
namespace {

using testing::refusal;

TEST(CanBus, RefusesUnknownAddressesWithASentence) {
  for (const char* const address : {"", "can0", "vcan:vcan0", "Socketcan:vcan0", "udp:239.74.163.2:43113"}) {
    EXPECT_THAT(refusal(address), ::testing::HasSubstr("use socketcan:<interface> or udp_multicast:"))
        << address;
  }
}

TEST(CanBus, RefusesBadMulticastAddressesWithASentence) {
  for (const char* const address : {"udp_multicast:239.74.163.2", "udp_multicast:239.74.163.2:",
                                    "udp_multicast:239.74.163.2:0", "udp_multicast:239.74.163.2:65536",
                                    "udp_multicast:239.74.163.2:43113x", "udp_multicast:239.74.163.2:-1"}) {
    EXPECT_THAT(refusal(address), ::testing::HasSubstr("needs a port from 1 to 65535")) << address;
  }
  for (const char* const group : {"", "10.0.0.1", "nonsense", "239.74.163", "240.0.0.1"}) {
    EXPECT_THAT(refusal(std::string("udp_multicast:") + group + ":43113"),
                ::testing::HasSubstr("is no IPv4 multicast group"))
        << group;
  }
}

TEST(CanBus, RefusesAnInterfaceThatDoesNotExist) {
  // Where the kernel has no CAN at all, it is this that the sentence says.
  EXPECT_THAT(refusal("socketcan:no_such_can"), ::testing::AnyOf(::testing::HasSubstr("\"no_such_can\""),
                                                                 ::testing::HasSubstr("udp_multicast")));
}

}  // namespace
}  // namespace sextant
