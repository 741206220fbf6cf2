#include "sextant/config/sensor_config.hpp"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;
using Settings = std::vector<std::string>;

std::string refusal(const Settings& settings) {
  try {
    (void)load_scenario_config(shipped_scenario, settings);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

SimulatedDriveIoParameters io_of(const Settings& settings) {
  return load_scenario_config(shipped_scenario, settings).drive.plant.io;
}

TEST(SensorConfig, TheDefaultIsIdeal) {
  EXPECT_TRUE(is_ideal(io_of({})));
  EXPECT_TRUE(is_ideal(load_ecu_config(shipped_ecu).drive.plant.io));
  EXPECT_TRUE(is_ideal(load_plant_config(shipped_plant).plant.io));
}

TEST(SensorConfig, EveryImperfectionIsSwitchedOnByItsOwnKey) {
  for (const char* setting :
       {"plant.sensors.sampling_lead_us=5", "plant.sensors.current.gain_error=0.02",
        "plant.sensors.current.offset_a=-0.5", "plant.sensors.current.noise_a=0.1",
        "plant.sensors.current.range_a=400", "plant.sensors.current.phase_a.offset_a=0.5",
        "plant.sensors.current.phase_b.gain_error=0.01", "plant.sensors.current.phase_c.offset_a=0.5",
        "plant.sensors.voltage.gain_error=0.01", "plant.sensors.voltage.offset_v=1",
        "plant.sensors.voltage.noise_v=1", "plant.sensors.voltage.range_v=1000",
        "plant.sensors.encoder.lines=1024", "plant.faults.kind=open_phase", "plant.inverter.dead_time_us=1.5",
        "plant.inverter.minimum_pulse_us=2"}) {
    SCOPED_TRACE(setting);
    EXPECT_FALSE(is_ideal(io_of({setting})));
  }
}

TEST(SensorConfig, GoesToTheSensorsOfEachPhase) {
  const SensorParameters s =
      io_of({"plant.sensors.current.gain_error=0.02", "plant.sensors.current.phase_b.gain_error=-0.05",
             "plant.sensors.current.phase_c.offset_a=0.5", "plant.sensors.current.bits=12",
             "plant.sensors.current.range_a=400", "plant.sensors.seed=7"})
          .sensors;
  EXPECT_DOUBLE_EQ(s.current_of(0).gain_error, 0.02);
  EXPECT_DOUBLE_EQ(s.current_of(1).gain_error, -0.03);
  EXPECT_DOUBLE_EQ(s.current_of(2).offset, 0.5);
  EXPECT_EQ(s.current_of(2).bits, 12);
  EXPECT_EQ(s.current_of(2).range, 400);
  EXPECT_EQ(s.seed, 7U);
}

TEST(SensorConfig, GoesToTheFault) {
  const PlantFaultParameters f =
      io_of({"plant.faults.kind=link_sag", "plant.faults.phase=c", "plant.faults.at_s=0.25",
             "plant.faults.until_s=0.75", "plant.faults.ramp_ms=2", "plant.u_dc_v=500"})
          .fault;
  EXPECT_EQ(f.kind, PlantFaultKind::link_sag);
  EXPECT_EQ(f.phase, 2);
  EXPECT_EQ(f.at_ns, 250'000'000);
  EXPECT_EQ(f.until_ns, 750'000'000);
  EXPECT_EQ(f.ramp_ns, 2'000'000);
  EXPECT_EQ(f.sag_voltage, 250) << "half of the link, unless given";
  EXPECT_EQ(io_of({}).fault.until_ns, PlantFaultParameters::never_ns);
}

TEST(SensorConfig, WhatContradictsItselfIsRefused) {
  EXPECT_THAT(refusal({"plant.sensors.current.bits=12"}), HasSubstr("a converter with bits needs a range"));
  EXPECT_THAT(refusal({"plant.sensors.voltage.bits=12"}), HasSubstr("a converter with bits needs a range"));
  EXPECT_THAT(refusal({"plant.sensors.sampling_lead_us=26"}),
              HasSubstr("the sampling lead must not exceed the control period"));
  EXPECT_THAT(refusal({"plant.inverter.dead_time_us=12.5"}),
              HasSubstr("plant: the dead time must be from zero to below half of the control period"));
  EXPECT_THAT(refusal({"plant.inverter.minimum_pulse_us=12.5"}),
              HasSubstr("plant: the minimum pulse must be from zero to below half of the control period"));
  EXPECT_THAT(refusal({"plant.inverter.dead_time_us=1.5", "plant.inverter.minimum_pulse_us=1.4"}),
              HasSubstr("the minimum pulse must be zero or at least the dead time"));
  EXPECT_THAT(
      refusal({"plant.sensors.current.gain_error=-0.9", "plant.sensors.current.phase_a.gain_error=-0.9"}),
      HasSubstr("the gain error must be above -1"));
  EXPECT_EQ(refusal({"plant.faults.at_s=0.5", "plant.faults.until_s=0.4"}),
            "--set: plant.faults: the fault must end after it began")
      << "once, of the two sections that check it";
  EXPECT_THAT(refusal({"plant.faults.kind=cables_swapped", "plant.faults.at_s=0.5"}),
              HasSubstr("swapped motor cables must be so from the beginning to the end"));
}

TEST(SensorConfig, TheLoopOfAResolverEndsAtTenKilohertz) {
  EXPECT_EQ(refusal({"plant.sensors.resolver.bandwidth_hz=10000"}), "accepted");
  EXPECT_THAT(refusal({"plant.sensors.resolver.bandwidth_hz=10001"}),
              HasSubstr("expected a number from 1 to 10000"));
}

TEST(SensorConfig, AnEventExactRunHasNoSamples) {
  EXPECT_THAT(refusal({"mode=event_exact", "plant.sensors.current.noise_a=0.1"}),
              HasSubstr("plant.sensors must be ideal"));
  EXPECT_THAT(refusal({"mode=event_exact", "plant.faults.kind=open_phase"}),
              HasSubstr("plant.faults.kind \"none\""));
  EXPECT_THAT(refusal({"mode=event_exact", "plant.inverter.dead_time_us=1"}),
              HasSubstr("plant.inverter.dead_time_us 0"));
  EXPECT_THAT(refusal({"mode=event_exact", "plant.inverter.minimum_pulse_us=2"}),
              HasSubstr("minimum_pulse_us 0"));
  for (const char* const drop : {"plant.inverter.threshold_v=1.2", "plant.inverter.slope_ohm=0.02"})
    EXPECT_THAT(refusal({"mode=event_exact", drop}), HasSubstr("threshold_v 0, slope_ohm 0"));
  EXPECT_EQ(refusal({"mode=event_exact"}), "accepted");
}

TEST(SensorConfig, APlantOutsideTheEcuHasTheSensors) {
  EXPECT_THAT(ecu_refusal(shipped_ecu_hil, {"plant.sensors.current.noise_a=0.1"}),
              HasSubstr("set plant.sensors, plant.inverter and plant.faults there"));
  for (const char* const key : {"dead_time_us=1.5", "threshold_v=1.2", "slope_ohm=0.02"})
    EXPECT_THAT(ecu_refusal(shipped_ecu_hil, {std::string("plant.inverter.") + key}),
                HasSubstr("set plant.sensors, plant.inverter and plant.faults there"));
  EXPECT_EQ(ecu_refusal(shipped_ecu, {"plant.sensors.current.noise_a=0.1"}), "accepted");
  EXPECT_FALSE(is_ideal(load_plant_config(shipped_plant, {"plant.faults.kind=speed_lost"}).plant.io));
}

std::string request_refusal(const std::string& request) {
  try {
    (void)requested_fault(request, {});
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(RequestedFault, HasWhatItGivesAndTheRestAsConfigured) {
  const PlantFaultParameters configured{
      .kind = PlantFaultKind::open_phase, .phase = 1, .drift = 3, .sag_voltage = 123.4};
  const PlantFaultParameters fault = requested_fault("kind=link_sag\nramp_ms=10\nuntil_s=2.5\n", configured);
  EXPECT_EQ(fault.kind, PlantFaultKind::link_sag);
  EXPECT_EQ(fault.ramp_ns, 10'000'000);
  EXPECT_EQ(fault.until_ns, 2'500'000'000);
  EXPECT_EQ(fault.phase, 1);
  EXPECT_EQ(fault.drift, 3);
  EXPECT_EQ(fault.sag_voltage, 123.4);
  EXPECT_EQ(requested_fault("sag_v=200", configured).sag_voltage, 200);
  EXPECT_EQ(requested_fault("", configured).kind, PlantFaultKind::open_phase);
}

TEST(RequestedFault, IsRefusedByTheSentencesOfItsKeys) {
  EXPECT_THAT(request_refusal("kind=\"open_fase\""),
              HasSubstr("plant.faults.kind: expected \"none\" or \"current_stuck\""));
  EXPECT_THAT(request_refusal("kind=cables_swapped"),
              HasSubstr("\"contactor_welded\", got \"cables_swapped\""));
  EXPECT_THAT(request_refusal("phase=d"), HasSubstr("plant.faults.phase: expected \"a\" or \"b\" or \"c\""));
  EXPECT_THAT(request_refusal("seed=3"), HasSubstr("plant.faults.seed: unknown key"));
  EXPECT_THAT(request_refusal("at_s=1\nuntil_s=0.5"),
              HasSubstr("plant.faults: the fault must end after it began"));
  EXPECT_THAT(request_refusal("nonsense"), HasSubstr("expected key=value"));
}

}  // namespace
}  // namespace sextant
