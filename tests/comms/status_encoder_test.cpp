#include "sextant/comms/status_encoder.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "sextant.h"

namespace sextant {
namespace {

constexpr std::int64_t ms = 1'000'000;

Telemetry<double> some_telemetry() {
  Telemetry<double> x;
  x.torque = 14.5;
  x.torque_reference = 15.0;
  x.psi_s_magnitude = 1.1;
  x.i_abc = {10.0, -5.0, -5.0};
  x.u_dc = 530.0;
  x.i_dc = 2.0;
  x.omega_m = 10.0 * std::numbers::pi;  // 300 rpm
  x.torque_motoring = 80.0;
  x.torque_regenerating = 100.0;
  x.state = DriveState::torque;
  x.derating_cause = DeratingCause::current_limit;
  x.lockout = false;
  x.command_sequence = 4;
  x.command_counter = 9;
  return x;
}

TEST(StatusEncoder, TakesItsSignalsFromTheTelemetry) {
  StatusEncoder encoder;
  const Telemetry<double> x = some_telemetry();
  sextant_mcu_torque_status_t t{};
  sextant_mcu_torque_status_unpack(&t, encoder.frame(StatusMessage::torque_status, x, {}).data.data(), 8);
  EXPECT_EQ(t.torque_estimated, 1450);
  EXPECT_EQ(t.torque_reference, 1500);
  EXPECT_EQ(t.drive_state, 4);
  EXPECT_EQ(t.command_counter, 9);
  sextant_mcu_motion_t m{};
  sextant_mcu_motion_unpack(&m, encoder.frame(StatusMessage::motion, x, {}).data.data(), 8);
  EXPECT_EQ(m.speed, 600);
  EXPECT_EQ(m.flux_magnitude, 11000);
  sextant_mcu_electrical_t e{};
  sextant_mcu_electrical_unpack(&e, encoder.frame(StatusMessage::electrical, x, {}).data.data(), 8);
  EXPECT_NEAR(sextant_mcu_electrical_phase_current_rms_decode(e.phase_current_rms), 10.0 / std::sqrt(2.0),
              0.01);
  EXPECT_NEAR(sextant_mcu_electrical_dc_voltage_decode(e.dc_voltage), 530.0, 1e-9);
  EXPECT_NEAR(sextant_mcu_electrical_dc_current_decode(e.dc_current), 2.0, 1e-9);
  sextant_mcu_capability_t c{};
  sextant_mcu_capability_unpack(&c, encoder.frame(StatusMessage::capability, x, {}).data.data(), 8);
  EXPECT_EQ(c.torque_motoring, 8000);
  EXPECT_EQ(c.torque_regenerating, 10000);
  EXPECT_EQ(c.derating_cause, 1);
  const auto temperatures = [&encoder](const Telemetry<double>& of) {
    sextant_mcu_temperatures_t k{};
    sextant_mcu_temperatures_unpack(&k, encoder.frame(StatusMessage::temperatures, of, {}).data.data(), 8);
    return k;
  };
  EXPECT_EQ(temperatures(x).stator_temperature, 65535);
  Telemetry<double> warm = x;
  warm.winding_temperature = 81.5;
  EXPECT_NEAR(sextant_mcu_temperatures_stator_temperature_decode(temperatures(warm).stator_temperature), 81.5,
              1e-9);
  EXPECT_EQ(temperatures(warm).rotor_temperature, 65535);
  EXPECT_EQ(encoder.clamped(), 0U);
}

TEST(StatusEncoder, EchoesNoCounterBeforeTheFirstCommand) {
  StatusEncoder encoder;
  sextant_mcu_torque_status_t t{};
  sextant_mcu_torque_status_unpack(&t, encoder.frame(StatusMessage::torque_status, {}, {}).data.data(), 8);
  EXPECT_EQ(t.command_counter, SEXTANT_MCU_TORQUE_STATUS_COMMAND_COUNTER_NONE_CHOICE);
}

TEST(StatusEncoder, SaysWhichSoftwareItIs) {
  StatusEncoder encoder;
  sextant_mcu_identification_t m{};
  sextant_mcu_identification_unpack(&m, encoder.frame(StatusMessage::identification, {}, {}).data.data(), 8);
  EXPECT_EQ(std::to_string(m.software_major) + "." + std::to_string(m.software_minor) + "." +
                std::to_string(m.software_patch),
            SEXTANT_VERSION);
}

TEST(StatusEncoder, ProtectedStreamsPassTheCheckOfTheirReceiver) {
  StatusEncoder encoder;
  std::map<std::uint32_t, E2eChecker> checkers;
  for (const unsigned id : {0x120U, 0x121U, 0x122U, 0x123U, 0x124U, 0x127U, 0x128U, 0x129U}) {
    checkers.emplace(id, E2eChecker(static_cast<std::uint16_t>(id)));
  }
  for (std::int64_t t = 0; t < 5000 * ms; t += 10 * ms) {
    for (const CanFrame& frame : encoder.due(t, some_telemetry(), {})) {
      const auto checker = checkers.find(frame.id);
      if (checker == checkers.end()) continue;
      e2e::Data data{};
      std::copy_n(frame.data.begin(), data.size(), data.begin());
      EXPECT_EQ(checker->second.check(data), E2eResult::ok) << std::hex << frame.id;
    }
  }
  for (const auto& [id, checker] : checkers) EXPECT_EQ(checker.state(), E2eState::valid);
}

e2e::Data payload_of(const CanFrame& frame) {
  e2e::Data data{};
  std::copy_n(frame.data.begin(), data.size(), data.begin());
  return data;
}

TEST(StatusEncoder, AnOffsetMovesEveryIdentifierAndEveryDataId) {
  for (const IdentifierOffset offset :
       {IdentifierOffset{32}, IdentifierOffset{256}, IdentifierOffset{1728}}) {
    SCOPED_TRACE(offset.value);
    StatusEncoder base;
    StatusEncoder moved{offset};
    const std::span<const CanFrame> own = base.due(0, some_telemetry(), {});
    const std::span<const CanFrame> other = moved.due(0, some_telemetry(), {});
    ASSERT_EQ(own.size(), status_message_count);
    ASSERT_EQ(other.size(), status_message_count);
    for (std::size_t i = 0; i < status_message_count; ++i) {
      SCOPED_TRACE(own[i].id);
      EXPECT_EQ(other[i].id, own[i].id + unsigned(offset.value));
      EXPECT_TRUE(is_status_frame(other[i], offset));
      EXPECT_FALSE(is_status_frame(other[i]));
      EXPECT_FALSE(is_status_frame(own[i], offset));
      if (own[i].id == 0x125 || own[i].id == 0x126) {  // not protected
        EXPECT_EQ(other[i].data, own[i].data);
        continue;
      }
      E2eChecker checker{std::uint16_t(other[i].id)};
      EXPECT_FALSE(usable(checker.check(payload_of(own[i])))) << "replayed onto the other drive's identifier";
      EXPECT_EQ(checker.check(payload_of(other[i])), E2eResult::ok);
    }
  }
}

TEST(StatusEncoder, SendsEachMessageAtItsCycleTime) {
  StatusEncoder encoder;
  std::map<std::uint32_t, int> sent;
  for (std::int64_t t = 5 * ms; t < 2005 * ms; t += ms) {
    for (const CanFrame& frame : encoder.due(t, some_telemetry(), {})) ++sent[frame.id];
  }
  EXPECT_EQ(sent, (std::map<std::uint32_t, int>{{0x120, 200},
                                                {0x121, 200},
                                                {0x122, 200},
                                                {0x123, 20},
                                                {0x124, 20},
                                                {0x125, 2},
                                                {0x126, 20},
                                                {0x127, 20},
                                                {0x128, 20},
                                                {0x129, 2}}));
}

TEST(StatusEncoder, SkipsMissedCyclesAndKeepsThePhase) {
  StatusEncoder encoder;
  EXPECT_EQ(encoder.next_due_ns(), 0);
  EXPECT_EQ(encoder.due(0, {}, {}).size(), status_message_count);
  EXPECT_EQ(encoder.next_due_ns(), 10 * ms);
  EXPECT_TRUE(encoder.due(9 * ms, {}, {}).empty());
  EXPECT_EQ(encoder.due(47 * ms, {}, {}).size(), 3U);
  EXPECT_EQ(encoder.next_due_ns(), 50 * ms);
}

TEST(StatusEncoder, SendsFaultsWhenTheyChange) {
  StatusEncoder encoder;
  Telemetry<double> x = some_telemetry();
  ASSERT_EQ(encoder.due(0, x, {}).size(), status_message_count);
  x.active.set(Fault::over_current);
  x.latched.set(Fault::over_current);
  x.first_fault = Fault::over_current;
  x.fault_total = 1;
  const auto frames = encoder.due(ms, x, {});
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0].id, 0x124U);
  EXPECT_EQ(frames[1].id, 0x127U);
  EXPECT_EQ(frames[2].id, 0x128U);
  sextant_mcu_faults_t m{};
  sextant_mcu_faults_unpack(&m, frames[0].data.data(), 8);
  EXPECT_EQ(m.first_fault, SEXTANT_MCU_FAULTS_FIRST_FAULT_OVER_CURRENT_CHOICE);
  sextant_mcu_faults_active_t active{};
  sextant_mcu_faults_active_unpack(&active, frames[1].data.data(), 8);
  EXPECT_EQ(active.active_over_current, 1);
  sextant_mcu_faults_latched_t latched{};
  sextant_mcu_faults_latched_unpack(&latched, frames[2].data.data(), 8);
  EXPECT_EQ(latched.latched_over_current, 1);
  EXPECT_TRUE(encoder.due(2 * ms, x, {}).empty());
  x.active = {};
  EXPECT_EQ(encoder.due(3 * ms, x, {}).size(), 3U) << "the fault is gone, and stays latched";
  x.latched = {};
  EXPECT_EQ(encoder.due(4 * ms, x, {}).size(), 3U) << "it was reset";
}

// Who reads the state finds its cause.
TEST(StatusEncoder, TheFirstFaultIsSentBeforeTheStateThatItCauses) {
  StatusEncoder encoder;
  const std::span<const CanFrame> frames = encoder.due(0, some_telemetry(), {});
  const auto place = [&](std::uint32_t id) {
    return std::ranges::find(frames, id, &CanFrame::id) - frames.begin();
  };
  EXPECT_LT(place(0x124), place(0x120));
}

TEST(StatusEncoder, SendsTheCapabilityWhenARampToZeroBeginsAndEnds) {
  StatusEncoder encoder;
  Telemetry<double> x = some_telemetry();
  (void)encoder.due(0, x, {});
  const auto is_sent = [&](std::int64_t t, DeratingCause cause) {
    x.derating_cause = cause;
    const std::span<const CanFrame> frames = encoder.due(t, x, {});
    return std::ranges::find(frames, 0x123U, &CanFrame::id) != frames.end();
  };
  EXPECT_FALSE(is_sent(1 * ms, DeratingCause::voltage_limit)) << "within its cycle time";
  EXPECT_TRUE(is_sent(2 * ms, DeratingCause::command_timeout));
  EXPECT_FALSE(is_sent(3 * ms, DeratingCause::command_timeout));
  EXPECT_TRUE(is_sent(4 * ms, DeratingCause::none));
}

TEST(StatusEncoder, CountsFramesWithAValueBeyondItsRange) {
  StatusEncoder encoder;
  Telemetry<double> x = some_telemetry();
  x.torque = 400.0;
  (void)encoder.frame(StatusMessage::torque_status, x, {});
  EXPECT_EQ(encoder.clamped(), 1U);
}

TEST(StatusEncoder, ItsFramesAreKnownByTheirIdentifiers) {
  StatusEncoder encoder;
  const std::span<const CanFrame> frames = encoder.due(0, some_telemetry(), {});
  ASSERT_EQ(frames.size(), status_message_count);
  for (CanFrame frame : frames) {
    EXPECT_TRUE(is_status_frame(frame));
    frame.extended = true;
    EXPECT_FALSE(is_status_frame(frame));
  }
  EXPECT_FALSE(is_status_frame(encode(TorqueCommand<>{}).frame));
  EXPECT_FALSE(is_status_frame({.id = frames.front().id, .error = true}));
}

}  // namespace
}  // namespace sextant
