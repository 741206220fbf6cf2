#include "sextant/comms/can_codec.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sextant.h"

namespace sextant {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

template <class Message>
Message unpack(const EncodedFrame& encoded, std::uint32_t id,
               int (*unpack_message)(Message*, const std::uint8_t*, std::size_t)) {
  EXPECT_EQ(encoded.frame.id, id);
  EXPECT_EQ(encoded.frame.length, 8);
  EXPECT_FALSE(encoded.frame.extended || encoded.frame.rtr || encoded.frame.error || encoded.frame.fd);
  Message message{};
  EXPECT_EQ(unpack_message(&message, encoded.frame.data.data(), 8), 0);
  return message;
}

auto torque_status(const TorqueStatus& x) {
  return unpack(encode(x), 0x120, sextant_mcu_torque_status_unpack);
}

TEST(CanCodec, CarriesTorqueStatus) {
  const auto m = torque_status({.torque = -123.456,
                                .torque_reference = 15.0,
                                .state = DriveState::derated,
                                .lockout = false,
                                .command_counter = 14});
  EXPECT_NEAR(sextant_mcu_torque_status_torque_estimated_decode(m.torque_estimated), -123.456, 0.00501);
  EXPECT_NEAR(sextant_mcu_torque_status_torque_reference_decode(m.torque_reference), 15.0, 1e-9);
  EXPECT_EQ(m.drive_state, SEXTANT_MCU_TORQUE_STATUS_DRIVE_STATE_DERATED_CHOICE);
  EXPECT_EQ(m.lockout, 0);
  EXPECT_EQ(m.command_counter, 14);
  EXPECT_EQ(torque_status({}).command_counter, SEXTANT_MCU_TORQUE_STATUS_COMMAND_COUNTER_NONE_CHOICE);
  EXPECT_EQ(torque_status({}).lockout, 1);
}

TEST(CanCodec, KeepsTheResolutionOfTheContractOverTheRange) {
  constexpr unsigned seed = 11;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> torque(-250.0, 250.0);
  std::uniform_real_distribution<double> speed(-1600.0, 1600.0);
  for (int i = 0; i < 2000; ++i) {
    const double tau = torque(random);
    const auto t = torque_status({.torque = tau, .torque_reference = -tau});
    EXPECT_LE(std::abs(sextant_mcu_torque_status_torque_estimated_decode(t.torque_estimated) - tau), 0.01);
    EXPECT_LE(std::abs(sextant_mcu_torque_status_torque_reference_decode(t.torque_reference) + tau), 0.01);
    const double omega_m = speed(random);
    const auto m = unpack(encode(Motion{.omega_m = omega_m}), 0x121, sextant_mcu_motion_unpack);
    EXPECT_LE(std::abs(sextant_mcu_motion_speed_decode(m.speed) - omega_m * 30.0 / std::numbers::pi), 0.2501);
  }
}

TEST(CanCodec, ClampsAndSaysSoInsteadOfWrapping) {
  for (const double value : {400.0, 1e300, infinity}) {
    const EncodedFrame high = encode(TorqueStatus{.torque = 0.0, .torque_reference = value});
    EXPECT_TRUE(high.clamped);
    EXPECT_EQ(unpack(high, 0x120, sextant_mcu_torque_status_unpack).torque_reference, 25000);
    const EncodedFrame low = encode(TorqueStatus{.torque = 0.0, .torque_reference = -value});
    EXPECT_TRUE(low.clamped);
    EXPECT_EQ(unpack(low, 0x120, sextant_mcu_torque_status_unpack).torque_reference, -25000);
  }
  EXPECT_FALSE(encode(TorqueStatus{.torque = -320.0, .torque_reference = 250.0}).clamped);
}

TEST(CanCodec, SendsNaNAsZeroAndSaysSo) {
  const EncodedFrame encoded = encode(TorqueStatus{.torque = nan});
  EXPECT_TRUE(encoded.clamped);
  EXPECT_EQ(unpack(encoded, 0x120, sextant_mcu_torque_status_unpack).torque_estimated, 0);
  EXPECT_TRUE(encode(Motion{.omega_m = nan}).clamped);
  EXPECT_TRUE(encode(Electrical{.u_dc = nan}).clamped);
  EXPECT_TRUE(encode(Capability{.torque_motoring = nan}).clamped);
  EXPECT_TRUE(encode(RealTimeReport{.worst_execution_time = nan}).clamped);
  EXPECT_TRUE(encode(Temperatures{.stator = nan}).clamped);
}

TEST(CanCodec, DerivesTheDirectionFromTheSpeedAsSent) {
  const auto direction = [](double rpm) {
    return unpack(encode(Motion{.omega_m = rpm * std::numbers::pi / 30.0}), 0x121, sextant_mcu_motion_unpack)
        .direction;
  };
  EXPECT_EQ(direction(0.2), SEXTANT_MCU_MOTION_DIRECTION_STANDSTILL_CHOICE);
  EXPECT_EQ(direction(-0.2), SEXTANT_MCU_MOTION_DIRECTION_STANDSTILL_CHOICE);
  EXPECT_EQ(direction(0.5), SEXTANT_MCU_MOTION_DIRECTION_FORWARD_CHOICE);
  EXPECT_EQ(direction(-1500.0), SEXTANT_MCU_MOTION_DIRECTION_REVERSE_CHOICE);
}

TEST(CanCodec, CarriesElectricalQuantities) {
  const auto m = unpack(encode(Electrical{.u_dc = 530.0, .i_dc = -4.0, .i_s_magnitude = 14.142135623730951}),
                        0x122, sextant_mcu_electrical_unpack);
  EXPECT_NEAR(sextant_mcu_electrical_dc_voltage_decode(m.dc_voltage), 530.0, 1e-9);
  EXPECT_NEAR(sextant_mcu_electrical_dc_current_decode(m.dc_current), -4.0, 1e-9);
  EXPECT_NEAR(sextant_mcu_electrical_phase_current_rms_decode(m.phase_current_rms), 10.0, 1e-9);
}

TEST(CanCodec, CarriesCapability) {
  const auto m =
      unpack(encode(Capability{
                 .torque_motoring = 130.0, .torque_regenerating = 90.5, .cause = DeratingCause::temperature}),
             0x123, sextant_mcu_capability_unpack);
  EXPECT_NEAR(sextant_mcu_capability_torque_motoring_decode(m.torque_motoring), 130.0, 1e-9);
  EXPECT_NEAR(sextant_mcu_capability_torque_regenerating_decode(m.torque_regenerating), 90.5, 1e-9);
  EXPECT_EQ(m.derating_cause, SEXTANT_MCU_CAPABILITY_DERATING_CAUSE_TEMPERATURE_CHOICE);
}

/// The frame as one number, as a VCU without a DBC would take it; the end-to-end bytes are its lowest 16
/// bits.
std::uint64_t bits_of(const EncodedFrame& encoded) {
  std::uint64_t bits = 0;
  for (std::size_t byte = 8; byte-- > 0;) bits = bits << 8U | encoded.frame.data[byte];
  return bits;
}

TEST(CanCodec, PutsEachFaultOnTheBitOfItsValue) {
  for (int i = 0; i < fault_count; ++i) {
    const auto fault = static_cast<Fault>(i);
    FaultSet one;
    one.set(fault);
    EXPECT_EQ(encode(ActiveFaults{one}).frame.id, 0x127U);
    EXPECT_EQ(bits_of(encode(ActiveFaults{one})), std::uint64_t{1} << (16 + i)) << to_string(fault);
    EXPECT_EQ(encode(LatchedFaults{one}).frame.id, 0x128U);
    EXPECT_EQ(bits_of(encode(LatchedFaults{one})), std::uint64_t{1} << (16 + i)) << to_string(fault);
    const std::uint64_t report = bits_of(encode(FaultReport{.first = fault, .total = 3}));
    EXPECT_EQ(report, std::uint64_t(i) << 16U | std::uint64_t{3} << 32U);
  }
}

TEST(CanCodec, IdentifiesTheSoftware) {
  const auto m = unpack(encode(Identification{.software_major = 1, .software_minor = 2, .software_patch = 3}),
                        0x129, sextant_mcu_identification_unpack);
  EXPECT_EQ(m.software_major, 1);
  EXPECT_EQ(m.software_minor, 2);
  EXPECT_EQ(m.software_patch, 3);
}

TEST(CanCodec, SaysThatThereIsNoFault) {
  const EncodedFrame encoded = encode(FaultReport{});
  const auto m = unpack(encoded, 0x124, sextant_mcu_faults_unpack);
  EXPECT_EQ(m.first_fault, SEXTANT_MCU_FAULTS_FIRST_FAULT_NONE_CHOICE);
  EXPECT_FALSE(encoded.clamped);
}

TEST(CanCodec, SaturatesCountersWithoutCallingThemOutOfRange) {
  const EncodedFrame encoded = encode(RealTimeReport{.periods_missed = std::uint64_t{1} << 60U,
                                                     .worst_execution_time = 1.0,
                                                     .worst_wake_latency = 39e-6,
                                                     .telemetry_dropped = 7});
  const auto m = unpack(encoded, 0x125, sextant_mcu_real_time_unpack);
  EXPECT_EQ(m.periods_missed, 65535);
  EXPECT_EQ(m.worst_execution_time, 65535);
  EXPECT_EQ(m.worst_wake_latency, 39);
  EXPECT_EQ(m.telemetry_dropped, 7);
  EXPECT_FALSE(encoded.clamped);
  EXPECT_EQ(unpack(encode(FaultReport{.total = 70'000}), 0x124, sextant_mcu_faults_unpack).fault_total,
            65535);
}

TEST(CanCodec, SendsUnknownTemperaturesAsNotAvailable) {
  const auto m = unpack(encode(Temperatures{.inverter = 41.5}), 0x126, sextant_mcu_temperatures_unpack);
  EXPECT_EQ(m.stator_temperature, SEXTANT_MCU_TEMPERATURES_STATOR_TEMPERATURE_NOT_AVAILABLE_CHOICE);
  EXPECT_EQ(m.rotor_temperature, SEXTANT_MCU_TEMPERATURES_ROTOR_TEMPERATURE_NOT_AVAILABLE_CHOICE);
  EXPECT_NEAR(sextant_mcu_temperatures_inverter_temperature_decode(m.inverter_temperature), 41.5, 1e-9);
}

TEST(CanCodec, NoClampedTemperatureReadsAsNotAvailable) {
  const EncodedFrame encoded = encode(Temperatures{.stator = 1e9, .rotor = -1e9});
  EXPECT_TRUE(encoded.clamped);
  const auto m = unpack(encoded, 0x126, sextant_mcu_temperatures_unpack);
  EXPECT_NEAR(sextant_mcu_temperatures_stator_temperature_decode(m.stator_temperature), 300.0, 1e-9);
  EXPECT_NEAR(sextant_mcu_temperatures_rotor_temperature_decode(m.rotor_temperature), -60.0, 1e-9);
}

TEST(CanCodec, ReturnsTheCommandThatWasEncoded) {
  for (const double torque : {-250.0, -15.0, -0.01, 0.0, 0.02, 129.99, 250.0}) {
    const DecodedCommand back = decode_command(
        encode(TorqueRequest{.torque = torque, .torque_limit = 200.0, .enable = true, .fault_reset = false})
            .frame);
    EXPECT_NEAR(back.request.torque, torque, 1e-9);
    EXPECT_NEAR(back.request.torque_limit, 200.0, 1e-9);
    EXPECT_TRUE(back.request.enable);
    EXPECT_FALSE(back.request.fault_reset);
    EXPECT_TRUE(back.in_range);
  }
  EXPECT_TRUE(decode_command(encode(TorqueRequest{.fault_reset = true}).frame).request.fault_reset);
}

TEST(CanCodec, SeesACommandBeyondTheRange) {
  CanFrame frame = encode(TorqueRequest{.torque = 250.0, .torque_limit = 250.0}).frame;
  EXPECT_TRUE(decode_command(frame).in_range);
  frame.data[2] = 0xA9;  // 25001 is 0x61A9
  EXPECT_FALSE(decode_command(frame).in_range);
  frame.data[2] = 0xA8;
  frame.data[4] = 0xA9;
  EXPECT_FALSE(decode_command(frame).in_range);
}

TEST(CanCodec, IdentifiesTheCommand) {
  const CanFrame good = encode(TorqueRequest{}).frame;
  EXPECT_EQ(identify_command(good), CommandIdentity::command);
  EXPECT_EQ(command_id(), 0x110U);
  EXPECT_EQ(command_data_id(), 0x110U);
  const auto with = [&good](auto change) {
    CanFrame frame = good;
    change(frame);
    return identify_command(frame);
  };
  EXPECT_EQ(with([](CanFrame& f) { f.id = 0x111; }), CommandIdentity::other);
  EXPECT_EQ(with([](CanFrame& f) { f.error = true; }), CommandIdentity::other);
  EXPECT_EQ(with([](CanFrame& f) { f.length = 7; }), CommandIdentity::wrong_length);
  EXPECT_EQ(with([](CanFrame& f) { f.length = 0; }), CommandIdentity::wrong_length);
  EXPECT_EQ(with([](CanFrame& f) { f.rtr = true; }), CommandIdentity::remote);
  EXPECT_EQ(with([](CanFrame& f) { f.extended = true; }), CommandIdentity::extended_alias);
  EXPECT_EQ(with([](CanFrame& f) { f.fd = true; }), CommandIdentity::fd_alias);
}

TEST(CanCodec, AVehicleReadsTheTorqueStatusThatWasEncoded) {
  const TorqueStatus sent{.torque = -12.34,
                          .torque_reference = 15.0,
                          .state = DriveState::derated,
                          .lockout = false,
                          .command_counter = 7};
  const auto read = decode_torque_status(encode(sent).frame);
  ASSERT_TRUE(read);
  EXPECT_NEAR(read->torque, sent.torque, 0.00501);
  EXPECT_NEAR(read->torque_reference, sent.torque_reference, 1e-9);
  EXPECT_EQ(read->state, sent.state);
  EXPECT_EQ(read->lockout, sent.lockout);
  EXPECT_EQ(read->command_counter, sent.command_counter);
  EXPECT_FALSE(decode_torque_status(encode(TorqueStatus{}).frame)->command_counter);
  EXPECT_EQ(torque_status_data_id(), 0x120);
}

TEST(CanCodec, NoOtherFrameIsATorqueStatus) {
  const CanFrame good = encode(TorqueStatus{}).frame;
  const auto with = [&](void (*change)(CanFrame&)) {
    CanFrame frame = good;
    change(frame);
    return decode_torque_status(frame).has_value();
  };
  EXPECT_TRUE(with([](CanFrame&) {}));
  EXPECT_FALSE(with([](CanFrame& f) { f.id = 0x121; }));
  EXPECT_FALSE(with([](CanFrame& f) { f.error = true; }));
  EXPECT_FALSE(with([](CanFrame& f) { f.length = 7; }));
  EXPECT_FALSE(with([](CanFrame& f) { f.rtr = true; }));
  EXPECT_FALSE(with([](CanFrame& f) { f.extended = true; }));
  EXPECT_FALSE(with([](CanFrame& f) { f.fd = true; }));
  EXPECT_FALSE(decode_torque_status(encode(TorqueRequest{}).frame));
}

}  // namespace
}  // namespace sextant
