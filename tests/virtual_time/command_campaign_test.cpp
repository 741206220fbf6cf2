// Rows 1 to 12, 17 and 18 of the fault list, in virtual time: what happens to commands, through codec, gate
// and cycle. docs/drive.md, "Fault reactions".

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include <gtest/gtest.h>

#include "comms/command_frames.hpp"
#include "virtual_time/campaign.hpp"

namespace sextant::test {
namespace {

constexpr std::uint64_t seeds = 40;

/// A rig with torque, at the instant of the fault.
struct Running {
  explicit Running(const CampaignCase& c) : rig{c.rig} {
    started = rig.start();
    rig.run_until(c.at_ns);
    rig.forget();
  }
  VirtualRig rig;
  bool started{false};
};

/// Row 2: ramp to zero within 60 ms of the last good command, a fault at 200 ms.
void expect_silence_reaction(Running& r, const CampaignCase& c) {
  const std::int64_t last_ns = r.rig.ecu.receiver().command().received_ns;
  double sum = 0.0;
  int count = 0;
  r.rig.on_period = [&](const Telemetry<double>& t) {
    if (t.t_ns < last_ns + 60 * ms || t.t_ns > last_ns + 160 * ms) return;
    EXPECT_EQ(t.torque_reference, 0.0);
    sum += t.torque;
    ++count;
  };
  r.rig.run_for(300 * ms);
  r.rig.on_period = {};
  ASSERT_EQ(r.rig.now().command_received_ns, last_ns) << "the commands went on";
  EXPECT_LE(r.rig.first_zero_ns, last_ns + 60 * ms);
  // Sampled direct torque control has a bias of some N·m; a drive that went on would show its torque.
  EXPECT_LT(std::abs(sum / count), std::max(3.0, 0.2 * std::abs(c.rig.torque)));
  EXPECT_GT(r.rig.first_fault_ns, last_ns + 200 * ms);
  EXPECT_LE(r.rig.first_fault_ns, last_ns + 200 * ms + VirtualRig::period_ns);
  EXPECT_EQ(r.rig.now().first_fault, Fault::command_lost);
}

TEST(CommandCampaign, Row1OneOrTwoLostFramesAreBridged) {
  for_seeds(seeds, [](CampaignCase& c) {
    Running r{c};
    ASSERT_TRUE(r.started);
    const auto lost = std::uint32_t(c.between(1, 2));
    r.rig.bus.add({.kind = BusEventKind::lose, .begin_ns = c.at_ns, .count = lost});
    const HoldsSetpoint watch{r.rig};
    const std::uint64_t before = r.rig.now().command_sequence;
    const std::uint32_t rejected = r.rig.now().command_rejected;
    r.rig.run_for(100 * ms);
    EXPECT_TRUE(watch.held());
    EXPECT_EQ(r.rig.bus.counts().lost, lost);
    EXPECT_EQ(r.rig.now().command_rejected, rejected) << "the frame after the gap is a good one";
    EXPECT_NEAR(double(r.rig.now().command_sequence - before), 10.0 - lost, 1.0);
  });
}

TEST(CommandCampaign, Row2SilenceRampsToZeroAndThenTrips) {
  for_seeds(seeds, [](CampaignCase& c) {
    Running r{c};
    ASSERT_TRUE(r.started);
    r.rig.vehicle.pause_sending(true);
    expect_silence_reaction(r, c);
  });
}

TEST(CommandCampaign, Row2SilenceBelow200MsHealsByItself) {
  for_seeds(seeds, [](CampaignCase& c) {
    Running r{c};
    ASSERT_TRUE(r.started);
    r.rig.vehicle.pause_sending(true);
    r.rig.run_for(c.between(60, 180) * ms);
    r.rig.vehicle.pause_sending(false);
    r.rig.run_for(50 * ms);
    EXPECT_NE(r.rig.first_zero_ns, never_ns);
    EXPECT_EQ(r.rig.first_fault_ns, never_ns);
    EXPECT_EQ(r.rig.now().torque_reference, c.rig.torque);
  });
}

TEST(CommandCampaign, Row3OneCorruptedFrameIsDropped) {
  for_seeds(seeds, [](CampaignCase& c) {
    Running r{c};
    ASSERT_TRUE(r.started);
    r.rig.bus.add({.kind = BusEventKind::corrupt,
                   .begin_ns = c.at_ns,
                   .count = 1,
                   .byte = std::uint8_t(c.between(0, 7)),
                   .mask = std::uint8_t(c.between(1, 255))});
    const HoldsSetpoint watch{r.rig};
    const std::uint32_t before = r.rig.now().command_rejected;
    r.rig.run_for(100 * ms);
    EXPECT_TRUE(watch.held());
    EXPECT_EQ(r.rig.now().command_rejected, before + 1);
    EXPECT_EQ(r.rig.ecu.receiver().count(FrameVerdict::wrong_crc), 1U);
  });
}

TEST(CommandCampaign, Row4CorruptionUntilInvalidTripsWithin10Ms) {
  for_seeds(seeds, [](CampaignCase& c) {
    Running r{c};
    ASSERT_TRUE(r.started);
    const auto byte = std::uint8_t(c.between(0, 7));
    const auto mask = std::uint8_t(c.between(1, 255));
    std::optional<std::int64_t> invalid_ns;
    r.rig.bus.watch([&](const CanFrame& frame) {
      const bool third = r.rig.bus.counts().corrupted == 3 && frame.id == command_id();
      if (third && !invalid_ns) invalid_ns = frame.received_ns;
    });
    r.rig.bus.add({.kind = BusEventKind::corrupt, .begin_ns = c.at_ns, .byte = byte, .mask = mask});
    r.rig.run_for(60 * ms);
    ASSERT_TRUE(invalid_ns);
    EXPECT_GE(r.rig.first_fault_ns, *invalid_ns);
    EXPECT_LE(r.rig.first_fault_ns, *invalid_ns + 10 * ms);
    EXPECT_EQ(r.rig.now().first_fault, Fault::command_invalid);
  });
}

TEST(CommandCampaign, Row5AFrozenCounterIsSilence) {
  for_seeds(seeds, [](CampaignCase& c) {
    Running r{c};
    ASSERT_TRUE(r.started);
    r.rig.vehicle.freeze_counter(true);
    r.rig.run_for(11 * ms);  // the first frame with the counter that stands still is a good one
    expect_silence_reaction(r, c);
    EXPECT_GE(r.rig.ecu.receiver().count(FrameVerdict::repeated), 28U);
  });
}

TEST(CommandCampaign, Row6ACounterJumpIsRefusedOnceAndFollowed) {
  for_seeds(seeds, [](CampaignCase& c) {
    Running r{c};
    ASSERT_TRUE(r.started);
    r.rig.vehicle.skip_counters(unsigned(c.between(3, 13)));  // steps of 4 to 14
    const HoldsSetpoint watch{r.rig};
    const std::uint32_t rejected = r.rig.now().command_rejected;
    // The first counter that a drive sees may have been a jump as well.
    const std::uint64_t jumps = r.rig.ecu.receiver().count(FrameVerdict::wrong_sequence);
    r.rig.run_for(100 * ms);
    EXPECT_TRUE(watch.held());
    EXPECT_EQ(r.rig.now().command_rejected, rejected + 1);
    EXPECT_EQ(r.rig.ecu.receiver().count(FrameVerdict::wrong_sequence), jumps + 1);
    EXPECT_LE(r.rig.clock.now_ns() - r.rig.now().command_received_ns, 11 * ms);
  });
}

/// Rows 7 and 8, for a frame that is sent beside the vehicle's.
void expect_dropped(Running& r, const CampaignCase& c, const CanFrame& frame, FrameVerdict expected) {
  r.rig.bus.add({.kind = BusEventKind::insert, .begin_ns = c.at_ns, .frame = frame});
  const HoldsSetpoint watch{r.rig};
  const std::uint32_t rejected = r.rig.now().command_rejected;
  r.rig.run_for(100 * ms);
  EXPECT_TRUE(watch.held());
  EXPECT_EQ(r.rig.now().command_rejected, rejected + 1);
  EXPECT_EQ(r.rig.ecu.receiver().count(expected), 1U);
}

TEST(CommandCampaign, Row7WrongDataIdAndCounter15AreDropped) {
  for_seeds(seeds, [](CampaignCase& c) {
    Running r{c};
    ASSERT_TRUE(r.started);
    CanFrame frame = encode(TorqueCommand<>{.torque = 77.0, .torque_limit = 100.0, .enable = true}).frame;
    const std::int64_t kind = c.between(0, 2);
    FrameVerdict expected = FrameVerdict::invalid_counter;
    if (kind == 0) {
      testing::protect(frame, command_data_id(), 15);
    } else if (kind == 1) {  // the CRC of another message
      testing::protect(frame, std::uint16_t(command_data_id() ^ std::uint16_t(c.between(1, 255))), 3);
      expected = FrameVerdict::wrong_crc;
    } else {  // the CRC holds, the nibble is another
      const auto nibble = std::uint16_t(c.between(1, 15));
      testing::protect(frame, std::uint16_t(command_data_id() ^ (nibble << 8U)), 3);
      expected = FrameVerdict::wrong_data_id;
    }
    expect_dropped(r, c, frame, expected);
  });
}

TEST(CommandCampaign, Row8FramesOfAnotherShapeAreDropped) {
  for_seeds(seeds, [](CampaignCase& c) {
    Running r{c};
    ASSERT_TRUE(r.started);
    CanFrame frame = testing::command_frame(std::uint8_t(c.between(0, 14)), 77.0);
    const std::int64_t kind = c.between(0, 3);
    FrameVerdict expected{};
    if (kind == 0) {
      frame.length = std::uint8_t(c.between(0, 7));
      expected = FrameVerdict::wrong_length;
    } else if (kind == 1) {
      frame.rtr = true;
      expected = FrameVerdict::remote_frame;
    } else if (kind == 2) {
      frame.extended = true;
      expected = FrameVerdict::extended_alias;
    } else {
      frame.fd = true;
      expected = FrameVerdict::fd_alias;
    }
    expect_dropped(r, c, frame, expected);
  });
}

/// Row 9, for as many frames in a row; `beyond` makes a vehicle send them.
template <class Beyond, class Within>
void expect_blocked(CampaignCase& c, Beyond&& beyond, Within&& within) {
  for (const int frames : {1, 2, 3}) {
    SCOPED_TRACE(frames);
    Running r{c};
    ASSERT_TRUE(r.started);
    const double before = r.rig.now().torque_reference;
    std::optional<std::int64_t> last_ns;
    std::uint64_t seen = 0;
    r.rig.bus.watch([&](const CanFrame& frame) {
      if (frame.id != command_id() || int(seen) == frames) return;
      last_ns = frame.received_ns;
      if (int(++seen) == frames) within(r.rig);
    });
    r.rig.on_period = [&](const Telemetry<double>& t) {
      if (!t.latched.any()) {
        EXPECT_EQ(t.torque_reference, before);
      }
    };
    beyond(r.rig, c);
    r.rig.run_for(100 * ms);
    ASSERT_EQ(int(seen), frames);
    if (frames < 3) {
      EXPECT_EQ(r.rig.first_fault_ns, never_ns);
      EXPECT_EQ(r.rig.now().state, DriveState::torque);
    } else {
      EXPECT_GE(r.rig.first_fault_ns, *last_ns);
      EXPECT_LE(r.rig.first_fault_ns, *last_ns + c.wake_ns());
      EXPECT_EQ(r.rig.now().first_fault, Fault::command_out_of_range);
    }
  }
}

TEST(CommandCampaign, Row9TorqueBeyondTheConfiguredLimitIsBlocked) {
  for_seeds(seeds / 2, [](CampaignCase& c) {
    const double sign = c.between(0, 1) == 0 ? -1.0 : 1.0;
    const double torque = sign * double(c.between(15'001, 24'999)) * 0.01;
    expect_blocked(
        c, [&](VirtualRig& rig, CampaignCase&) { rig.torque = torque; },
        [&](VirtualRig& rig) { rig.torque = c.rig.torque; });
  });
}

TEST(CommandCampaign, Row9TorqueBeyondTheContractIsBlocked) {
  for_seeds(seeds / 2, [](CampaignCase& c) {
    const std::int64_t sign = c.between(0, 1) == 0 ? -1 : 1;
    const auto raw = std::uint16_t(std::int16_t(sign * c.between(25'001, 32'767)));
    expect_blocked(
        c,
        [&](VirtualRig& rig, CampaignCase&) {
          rig.vehicle.tamper([raw](e2e::Data& data) {  // TorqueRequest, little-endian in bytes 2 and 3
            data[2] = std::uint8_t(raw & 0xFFU);
            data[3] = std::uint8_t(raw >> 8U);
          });
        },
        [](VirtualRig& rig) { rig.vehicle.tamper({}); });
  });
}

TEST(CommandCampaign, Row10ATorqueStepIsFollowedAtTheConfiguredRate) {
  for_seeds(seeds, [](CampaignCase& c) {
    const double rate = double(c.between(200, 4000));
    c.rig.config.drive.command.torque_rate = rate;
    Running r{c};
    ASSERT_TRUE(r.started);
    r.rig.run_for(std::int64_t(std::abs(c.rig.torque) / rate * 1e9));
    const double from = r.rig.now().torque_reference;
    ASSERT_EQ(from, c.rig.torque);
    const double to = -from;
    double last = from;
    std::int64_t last_ns = r.rig.now().t_ns;
    double steepest = 0.0;
    r.rig.on_period = [&](const Telemetry<double>& t) {
      const double dt = double(t.t_ns - last_ns) * 1e-9;
      if (dt > 0.0) steepest = std::max(steepest, std::abs(t.torque_reference - last) / dt);
      last = t.torque_reference;
      last_ns = t.t_ns;
    };
    r.rig.torque = to;
    r.rig.run_for(20 * ms + std::int64_t(2.0 * std::abs(from) / rate * 1e9));
    EXPECT_LE(steepest, rate * (1.0 + 1e-6));
    EXPECT_GT(steepest, rate * 0.999);
    EXPECT_EQ(r.rig.now().torque_reference, to);
    EXPECT_EQ(r.rig.first_fault_ns, never_ns);
  });
}

TEST(CommandCampaign, Row11MoreThanAvailableDeratesAndNeverTrips) {
  for_seeds(seeds, [](CampaignCase& c) {
    const double available = double(c.between(5, 35));
    c.rig.config.drive.motor.capability.torque = available;
    c.rig.torque = (c.rig.torque < 0 ? -1.0 : 1.0) * std::min(available, 4.0);
    Running r{c};
    ASSERT_TRUE(r.started);
    EXPECT_EQ(r.rig.now().state, DriveState::torque);
    const double sign = c.rig.torque < 0 ? -1.0 : 1.0;
    r.rig.torque = sign * (available + double(c.between(1, 100)));
    r.rig.run_for(200 * ms);
    EXPECT_EQ(r.rig.now().state, DriveState::derated);
    EXPECT_NEAR(r.rig.now().torque_reference, sign * available, 1e-9);
    EXPECT_EQ(r.rig.first_fault_ns, never_ns);
  });
}

TEST(CommandCampaign, Row12AnEnableAtPowerUpStaysLockedOut) {
  for_seeds(seeds, [](CampaignCase& c) {
    c.rig.vehicle.hand_shake = false;
    VirtualRig rig{c.rig};
    bool locked = true;
    rig.on_period = [&](const Telemetry<double>& t) {
      locked = locked && t.lockout && !gates_are_on(t.state) && t.pattern.last_state() == gates_off;
    };
    rig.run_until(500 * ms);
    EXPECT_TRUE(locked);
    EXPECT_GT(rig.now().command_sequence, 40U) << "the commands have to arrive";
    EXPECT_EQ(rig.now().state, DriveState::standby);
  });
}

TEST(CommandCampaign, Row17BusOffTripsWithin10Ms) {
  for_seeds(seeds, [](CampaignCase& c) {
    c.rig.vehicle.clear_faults = true;
    Running r{c};
    ASSERT_TRUE(r.started);
    const std::int64_t away_ns = c.between(1, 100) * ms;
    r.rig.bus.add({.kind = BusEventKind::bus_off, .begin_ns = c.at_ns, .end_ns = c.at_ns + away_ns});
    r.rig.run_for(10 * ms);
    EXPECT_LE(r.rig.first_fault_ns, c.at_ns + 10 * ms);
    EXPECT_TRUE(r.rig.now().latched.test(Fault::bus_off));
    EXPECT_EQ(r.rig.now().first_fault, Fault::bus_off);
    EXPECT_EQ(r.rig.now().pattern.last_state(), gates_off);
    // Reset, disable, enable bring it back once the bus is back.
    r.rig.run_for(away_ns + 400 * ms);
    EXPECT_EQ(r.rig.now().state, DriveState::torque);
    EXPECT_EQ(r.rig.bus.stats().bus_off, 1U);
  });
}

// A controller that falls off again and again: the vehicle asks for a reset all the while, and gets none.
TEST(CommandCampaign, Row17ABusOffThatIsReportedAgainAndAgainIsNotReset) {
  for_seeds(seeds, [](CampaignCase& c) {
    c.rig.vehicle.clear_faults = true;
    Running r{c};
    ASSERT_TRUE(r.started);
    const CanFrame report{.id = can_error_bus_off, .error = true, .length = 8};
    const std::int64_t end_ns = c.at_ns + 200 * ms;
    for (std::int64_t t = c.at_ns; t < end_ns; t += 5 * ms) {
      r.rig.bus.add({.kind = BusEventKind::insert, .begin_ns = t, .frame = report});
    }
    r.rig.run_for(10 * ms);
    bool stays = true;
    r.rig.on_period = [&](const Telemetry<double>& t) { stays = stays && t.state == DriveState::fault; };
    r.rig.run_until(end_ns);
    EXPECT_TRUE(stays);
    EXPECT_EQ(r.rig.vehicle.phase(), VirtualVehicle::Phase::resetting);
    EXPECT_EQ(r.rig.now().fault_total, 1U);
    r.rig.run_for(400 * ms);
    EXPECT_EQ(r.rig.now().state, DriveState::torque) << "the bus is back";
  });
}

// A disable that an enable overwrites before the control thread wakes up.
TEST(CommandCampaign, ADisableBetweenTwoWakeUpsTurnsTheGatesOff) {
  for_seeds(seeds, [](CampaignCase& c) {
    Running r{c};
    ASSERT_TRUE(r.started);
    r.rig.vehicle.pause_sending(true);
    const unsigned last = r.rig.ecu.receiver().command().counter;
    bool opened = false;
    r.rig.on_period = [&](const Telemetry<double>& t) { opened = opened || t.state == DriveState::ready; };
    r.rig.bus.put(testing::command_frame(std::uint8_t((last + 1) % 15), c.rig.torque, 0, false));
    r.rig.bus.put(testing::command_frame(std::uint8_t((last + 2) % 15), c.rig.torque, 0, true));
    r.rig.run_for(5 * ms);
    EXPECT_TRUE(opened);
    EXPECT_EQ(r.rig.now().state, DriveState::torque) << "the enable holds";
    EXPECT_EQ(r.rig.now().fault_total, 0U);
  });
}

/// MCU_TorqueStatus as another drive sends it.
CanFrame status_of_another(std::uint8_t counter) {
  CanFrame frame =
      encode(TorqueStatus{.torque = 15.0, .state = DriveState::torque, .command_counter = {}}).frame;
  testing::protect(frame, torque_status_data_id(), counter);
  return frame;
}

TEST(CommandCampaign, AnotherDriveOnTheBusIsAFaultAsLongAsItIsThere) {
  for_seeds(seeds, [](CampaignCase& c) {
    c.rig.vehicle.clear_faults = true;
    Running r{c};
    ASSERT_TRUE(r.started);
    const std::int64_t end_ns = c.at_ns + 500 * ms;
    std::uint8_t counter = c.rig.vehicle.first_counter;
    for (std::int64_t t = c.at_ns; t < end_ns; t += 10 * ms) {
      r.rig.bus.add({.kind = BusEventKind::insert, .begin_ns = t, .frame = status_of_another(counter)});
      counter = std::uint8_t((counter + 1) % 15);
    }
    r.rig.run_for(40 * ms);
    EXPECT_LE(r.rig.first_fault_ns, c.at_ns + 40 * ms);
    EXPECT_EQ(r.rig.now().first_fault, Fault::second_master);
    EXPECT_EQ(r.rig.now().pattern.last_state(), gates_off);
    r.rig.run_until(end_ns + 900 * ms);
    EXPECT_EQ(r.rig.now().state, DriveState::fault) << "no reset while it was heard a second ago";
    r.rig.run_for(500 * ms);
    EXPECT_EQ(r.rig.now().state, DriveState::torque) << "it is gone";
  });
}

TEST(CommandCampaign, AnotherDriveKeepsTheGatesOfADriveAtRestOff) {
  VirtualRig rig;
  std::uint8_t counter = 0;
  for (std::int64_t t = 0; t < 500 * ms; t += 10 * ms) {
    rig.bus.add({.kind = BusEventKind::insert, .begin_ns = t, .frame = status_of_another(counter)});
    counter = std::uint8_t((counter + 1) % 15);
  }
  rig.run_until(500 * ms);
  EXPECT_EQ(rig.now().state, DriveState::fault);
  EXPECT_EQ(rig.now().first_fault, Fault::second_master);
  EXPECT_FALSE(rig.vehicle.enabled_ns());
}

TEST(CommandCampaign, FramesUnderTheStatusIdentifierThatAreNoStreamAreNoDrive) {
  for_seeds(seeds, [](CampaignCase& c) {
    Running r{c};
    ASSERT_TRUE(r.started);
    for (int n = 0; n < 40; ++n) {
      CanFrame frame = status_of_another(std::uint8_t(c.between(0, 14)));
      if (n % 2 == 0) frame.data[std::size_t(c.between(0, 7))] ^= std::uint8_t(c.between(1, 255));
      if (n % 2 == 1) frame = status_of_another(7);  // one recorded frame, over and over
      r.rig.bus.add({.kind = BusEventKind::insert, .begin_ns = c.at_ns + n * 2 * ms, .frame = frame});
    }
    const HoldsSetpoint watch{r.rig};
    r.rig.run_for(150 * ms);
    EXPECT_TRUE(watch.held());
  });
}

// What a vehicle hears while the control thread is away, and that it is what the drive does once it is back.
TEST(CommandCampaign, Row27AControlThreadThatTimedOutIsAFaultOnTheBusWithin100Ms) {
  for_seeds(seeds, [](CampaignCase& c) {
    const std::int64_t away_ns = c.between(120, 400) * ms;
    c.rig.late_wakes = {{.at_ns = c.at_ns, .latency_ns = away_ns}};
    Running r{c};
    ASSERT_TRUE(r.started);
    std::int64_t told_ns = never_ns;
    bool took_it_back = false;
    r.rig.bus.listen([&](const CanFrame& frame) {
      const std::optional<TorqueStatus> status = decode_torque_status(frame);
      if (!status || r.rig.clock.now_ns() <= c.at_ns) return;
      const bool fault = status->state == DriveState::fault;
      if (fault) told_ns = std::min(told_ns, r.rig.clock.now_ns());
      if (!fault && told_ns != never_ns) took_it_back = true;
      EXPECT_TRUE(!fault || status->torque_reference == 0.0);
    });
    r.rig.run_for(away_ns + 100 * ms);
    EXPECT_LE(told_ns, c.at_ns + 100 * ms);
    EXPECT_FALSE(took_it_back) << "what was said has become true";
    EXPECT_EQ(r.rig.now().first_fault, Fault::watchdog);
    EXPECT_EQ(r.rig.now().fault_total, 1U);
  });
}

TEST(CommandCampaign, Row18AnInterfaceThatGoesDownIsSilence) {
  for_seeds(seeds, [](CampaignCase& c) {
    Running r{c};
    ASSERT_TRUE(r.started);
    r.rig.bus.add({.kind = BusEventKind::interface_down, .begin_ns = c.at_ns});
    expect_silence_reaction(r, c);
  });
}

TEST(CommandCampaign, Row18AnInterfaceThatComesBackHeals) {
  for_seeds(seeds, [](CampaignCase& c) {
    c.rig.vehicle.clear_faults = true;
    Running r{c};
    ASSERT_TRUE(r.started);
    const std::int64_t away_ns = c.between(60, 400) * ms;
    r.rig.bus.add({.kind = BusEventKind::interface_down, .begin_ns = c.at_ns, .end_ns = c.at_ns + away_ns});
    r.rig.run_for(away_ns + 400 * ms);
    EXPECT_EQ(r.rig.now().state, DriveState::torque);
    EXPECT_EQ(r.rig.now().torque_reference, c.rig.torque);
    EXPECT_EQ(r.rig.bus.stats().reopened, 1U);
    // Above 200 ms it trips, and the vehicle clears it; a few frames around the limit decide.
    if (away_ns > 210 * ms) {
      EXPECT_NE(r.rig.first_fault_ns, never_ns);
    }
    if (away_ns < 180 * ms) {
      EXPECT_EQ(r.rig.first_fault_ns, never_ns);
    }
  });
}

}  // namespace
}  // namespace sextant::test
