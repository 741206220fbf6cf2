// Drive and plant over the loopback interface, in one process, period by period.
#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "sextant/hil/udp_drive_io.hpp"
#include "sextant/hil/udp_plant_end.hpp"

namespace sextant {
namespace {

constexpr std::int32_t period_ns = 1'000'000;
const GatePattern v1{switch_states[1], period_ns};
const GatePattern open{gates_off, period_ns};

/// A free port of the loopback interface.
int free_port() {
  const int file = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  bind(file, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  getsockname(file, reinterpret_cast<sockaddr*>(&address), &length);
  close(file);
  return ntohs(address.sin_port);
}

class UdpLinkTest : public testing::Test {
 protected:
  UdpLinkTest() {
    const int port = free_port();
    int other_port = port;
    while (other_port == port) other_port = free_port();
    const std::string here = "127.0.0.1:" + std::to_string(port);
    const std::string there = "127.0.0.1:" + std::to_string(other_port);
    drive_parameters.udp_listen = plant_parameters.udp_peer = here;
    drive_parameters.udp_peer = plant_parameters.udp_listen = there;
    drive.emplace(drive_parameters, period_ns);
    plant.emplace(plant_parameters, period_ns);
    (void)drive->read(0);  // the first one discards what has queued up
  }

  void publish(SwitchState applied, std::uint64_t command_taken = 0) {
    Measurement<double> m{.u_dc = 530, .applied = {applied, period_ns}};
    MeasurementRecord record = to_record(t_ns += period_ns, m);
    record.pattern_number = command_taken;
    plant->publish(record);
  }
  Measurement<double> read() { return drive->read(t_ns); }

  HilParameters drive_parameters{};
  HilParameters plant_parameters{};
  std::optional<UdpDriveIo> drive{};
  std::optional<UdpPlantEnd> plant{};
  std::int64_t t_ns{0};
};

TEST_F(UdpLinkTest, MeasurementsComeOverAndAreJoined) {
  EXPECT_FALSE(read().plausible);
  publish(switch_states[1]);
  EXPECT_TRUE(read().plausible);
  publish(switch_states[1]);
  publish(switch_states[2]);
  const Measurement<double> m = read();
  EXPECT_TRUE(m.plausible);
  EXPECT_EQ(m.u_dc, 530.0);
  GatePattern expected = v1;
  expected.append({switch_states[2], period_ns});
  EXPECT_EQ(m.applied, expected);
  EXPECT_EQ(drive->counts()->network->received.received, 3U);
}

TEST_F(UdpLinkTest, WhatQueuedUpBeforeTheFirstReadIsNoMeasurementAndNoLoss) {
  drive.reset();
  drive.emplace(drive_parameters, period_ns);
  for (int n = 0; n < 50; ++n) publish(switch_states[1]);
  EXPECT_FALSE(read().plausible);
  publish(switch_states[2]);
  const Measurement<double> m = read();
  EXPECT_EQ(m.applied, (GatePattern{switch_states[2], period_ns}));
  EXPECT_EQ(drive->counts()->network->received.received, 1U);
  EXPECT_EQ(drive->counts()->network->received.lost, 0U);
}

TEST_F(UdpLinkTest, PatternsAndTheEnableLineComeOver) {
  DrivePatternRecord command;
  EXPECT_FALSE(plant->take(command));
  drive->write(v1);
  ASSERT_TRUE(plant->take(command));
  const std::uint64_t first = command.sequence;
  EXPECT_FALSE(plant->gates_enabled()) << "the line closes on gates off only";
  drive->write(open);
  drive->write(v1);
  ASSERT_TRUE(plant->take(command));
  EXPECT_TRUE(plant->gates_enabled());
  EXPECT_TRUE(plant->drive_present());
  GatePattern pattern;
  EXPECT_TRUE(to_pattern(command.pattern, pattern));
  EXPECT_EQ(pattern, v1);
  EXPECT_EQ(command.sequence, first + 2);
  EXPECT_FALSE(plant->take(command)) << "each once";
  drive->inhibit_gates();
  ASSERT_TRUE(plant->take(command));
  EXPECT_FALSE(plant->gates_enabled());
  drive->write(v1);
  ASSERT_TRUE(plant->take(command));
  EXPECT_FALSE(plant->gates_enabled()) << "a torque pattern does not bring it back";
}

TEST_F(UdpLinkTest, ADriveThatLeavesSaysSo) {
  DrivePatternRecord command;
  drive->write(open);
  ASSERT_TRUE(plant->take(command));
  drive.reset();
  ASSERT_TRUE(plant->take(command));
  EXPECT_FALSE(plant->drive_present());
  EXPECT_FALSE(plant->gates_enabled());
}

TEST_F(UdpLinkTest, APlantThatStoodStillFollowsTheNewestCommandAndNoOlderOne) {
  DrivePatternRecord command;
  drive->write(open);
  ASSERT_TRUE(plant->take(command));
  const std::uint64_t first = command.sequence;
  for (int n = 0; n < 50; ++n) drive->write(v1);  // the plant stands still meanwhile
  drive->inhibit_gates();
  ASSERT_TRUE(plant->take(command));
  EXPECT_EQ(command.sequence, first + 51);
  EXPECT_FALSE(plant->gates_enabled());
  EXPECT_FALSE(plant->take(command)) << "nothing is left of what queued up";
}

// More than the kernel keeps: the newest of them are lost, so that the newest that is there is an old one.
TEST_F(UdpLinkTest, APlantThatStoodStillForLongWaitsForTheNextCommand) {
  DrivePatternRecord command;
  drive->write(open);
  ASSERT_TRUE(plant->take(command));
  const std::uint64_t first = command.sequence;
  for (int n = 0; n < 3000; ++n) drive->write(v1);
  drive->inhibit_gates();
  EXPECT_FALSE(plant->take(command));
  for (int n = 0; n < 4; ++n) {
    EXPECT_FALSE(plant->take(command)) << n;
    drive->write(v1);
  }
  ASSERT_TRUE(plant->take(command)) << "the fourth in a row";
  EXPECT_EQ(command.sequence, first + 3005);
  EXPECT_FALSE(plant->gates_enabled());
}

// Only the way from the drive to the plant is cut: the plant turns its gates off, and the drive trips.
TEST_F(UdpLinkTest, ADriveWhoseCommandsGetLostTripsThoughMeasurementsCome) {
  DrivePatternRecord command;
  for (int n = 0; n < 20; ++n) {
    publish(switch_states[1], command.sequence);
    EXPECT_TRUE(read().plausible) << n;
    drive->write(n == 0 ? open : v1);
    ASSERT_TRUE(plant->take(command));
  }
  int periods = 0;
  bool plausible = true;
  while (plausible && periods < 100) {
    // What came over last acts, then nothing.
    publish(periods == 0 ? switch_states[1] : gates_off, command.sequence);
    plausible = read().plausible;
    drive->write(v1);  // nobody takes it
    ++periods;
  }
  EXPECT_EQ(periods, 1 + int(drive_parameters.pattern_timeout_ns / period_ns));
  EXPECT_TRUE(drive->link_state()->unacknowledged());
  EXPECT_FALSE(drive->link_state()->timed_out());
}

// The numbers that a plant had from an earlier drive are no answer to this one.
TEST_F(UdpLinkTest, EachStartOfADriveHasNumbersOfItsOwn) {
  DrivePatternRecord command;
  for (int n = 0; n < 10; ++n) drive->write(open);
  ASSERT_TRUE(plant->take(command));
  const std::uint64_t before = command.sequence;
  drive.reset();
  drive.emplace(drive_parameters, period_ns);
  (void)read();
  for (int n = 0; n < 20; ++n) {
    publish(gates_off, before);
    (void)read();
    drive->write(open);
  }
  EXPECT_TRUE(drive->link_state()->unacknowledged());
}

/// Stands where the drive is, drops what it is told to and passes the rest on.
class UdpLossTest : public UdpLinkTest, public testing::WithParamInterface<int> {};

TEST_P(UdpLossTest, LostDatagramsAreMadeUpForByTheNextUpToSevenInARow) {
  publish(switch_states[1]);
  ASSERT_TRUE(read().plausible);
  // The datagrams go to a socket that is closed before it is read: lost on the way.
  const int lost = GetParam();
  drive.reset();
  for (int n = 0; n < lost; ++n) publish(switch_states[1]);
  MeasurementDatagram datagram;
  DatagramReception reception{DatagramKind::measurement, period_ns, 10'000'000};
  UdpSocket other{drive_parameters.udp_listen, drive_parameters.udp_peer};
  publish(switch_states[2]);
  ASSERT_EQ(other.receive(std::as_writable_bytes(std::span{&datagram, 1})), sizeof datagram);
  ASSERT_TRUE(reception.accept(datagram.header, sizeof datagram, sizeof datagram, 0));
  MeasurementAssembler assembler{{.measurement_timeout_ns = 1'000'000'000}};
  // What the drive had before.
  MeasurementRecord first = datagram.records[0];
  first.sequence = 1;
  assembler.add(first);
  (void)assembler.take(0);
  for (std::size_t n = datagram.header.count; n-- > 0;) {
    if (datagram.records[n].sequence > assembler.newest().sequence) assembler.add(datagram.records[n]);
  }
  const Measurement<double> m = assembler.take(0);
  EXPECT_EQ(m.plausible, lost <= 7);
  if (lost <= 7) {
    EXPECT_EQ(m.applied.duration_ns(), std::int64_t{lost + 1} * period_ns) << "nothing is missing";
  }
}

INSTANTIATE_TEST_SUITE_P(Losses, UdpLossTest, testing::Values(0, 1, 6, 7, 8, 20));

TEST_F(UdpLinkTest, AddressesThatAreNoneAreRefusedByName) {
  const auto refusal = [](const std::string& listen, const std::string& peer) -> std::string {
    try {
      const UdpSocket refused{listen, peer};
    } catch (const std::runtime_error& problem) {
      return problem.what();
    }
    return "accepted";
  };
  using ::testing::HasSubstr;
  for (const char* bad :
       {"", "nowhere", "1.2.3.4", "1.2.3.4:", "1.2.3.4:0", "1.2.3.4:65536", "a.b:1", "1.2.3.4:5x"}) {
    EXPECT_THAT(refusal("0.0.0.0:47999", bad), HasSubstr("hil.udp_peer: \"" + std::string{bad} + "\""))
        << bad;
    EXPECT_THAT(refusal(bad, "127.0.0.1:1"), HasSubstr("hil.udp_listen: \"" + std::string{bad} + "\""))
        << bad;
  }
  EXPECT_THAT(refusal(drive_parameters.udp_listen, "127.0.0.1:1"), HasSubstr("cannot be listened on"));
}

TEST_F(UdpLinkTest, APlantThatIsNotThereIsNoError) {
  plant.reset();
  for (int n = 0; n < 50; ++n) {
    drive->write(open);
    EXPECT_FALSE(drive->read(t_ns += period_ns).plausible);
  }
  plant.emplace(plant_parameters, period_ns);
  publish(switch_states[1]);
  EXPECT_TRUE(read().plausible);
}

}  // namespace
}  // namespace sextant
