// Every fault of the contract, through codec, gate and cycle in virtual time: raised within its bound, not
// raised just inside the limit, latched, and left by reset, disable, enable. SEXTANT_CAMPAIGN_SEEDS sets the
// number of seeds; scripts/fault_campaign runs a hundred.

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "virtual_time/fault_injections.hpp"
#include "virtual_time/injection_run.hpp"

namespace sextant::test {

void PrintTo(const Injection& injection, std::ostream* out) {
  *out << injection.name;
}

namespace {

std::uint64_t seeds() {
  const char* text = std::getenv("SEXTANT_CAMPAIGN_SEEDS");
  return text == nullptr ? 3 : std::strtoull(text, nullptr, 10);
}

std::string test_name(const ::testing::TestParamInfo<Injection>& info) {
  std::string name;
  for (const char c : info.param.name) name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
}

/// Runs `body` for all seeds, operating points, and sensors.
template <class Body>
void for_plans(std::uint64_t count, bool just_inside, const Body& body) {
  for (std::uint64_t seed = 1; seed <= count; ++seed) {
    for (std::size_t point = 0; point < OperatingPoints{}.size(); ++point) {
      for (const bool real_sensors : {false, true})
        body(InjectionPlan{seed, point, real_sensors, just_inside});
    }
  }
}

class FaultCampaign : public ::testing::TestWithParam<Injection> {};

TEST_P(FaultCampaign, RaisesTheFaultWithinItsBoundAndTurnsTheGatesOff) {
  const Injection& injection = GetParam();
  for_plans(seeds(), false, [&](const InjectionPlan& plan) {
    const CampaignCase c = prepared(injection, plan);
    SCOPED_TRACE(c.text() + (plan.real_sensors ? ", real sensors" : ""));
    VirtualRig rig{c.rig};
    const InjectionResult result = run_injection(injection, c, rig);
    EXPECT_TRUE(result.started);
    EXPECT_TRUE(result.raised);
    EXPECT_TRUE(result.named) << "the first is " << to_string(result.first);
    EXPECT_TRUE(result.gates_off);
    EXPECT_LE(result.reaction_ns, injection.bound_ns);
  });
}

class FaultLimit : public ::testing::TestWithParam<Injection> {};

TEST_P(FaultLimit, RaisesNothingJustInside) {
  const Injection& injection = GetParam();
  for_plans(seeds(), true, [&](const InjectionPlan& plan) {
    const CampaignCase c = prepared(injection, plan);
    SCOPED_TRACE(c.text() + (plan.real_sensors ? ", real sensors" : ""));
    VirtualRig rig{c.rig};
    const InjectionResult result = run_injection(injection, c, rig);
    EXPECT_TRUE(result.started);
    EXPECT_FALSE(result.raised) << to_string(result.first);
    EXPECT_FALSE(rig.now().latched.any());
  });
}

/// Every frame of the vehicle becomes this command.
void send_only(VirtualRig& rig, const TorqueCommand<double>& command) {
  rig.vehicle.tamper([frame = encode(command).frame](e2e::Data& payload) {
    std::copy_n(frame.data.begin(), payload.size(), payload.begin());
  });
  rig.run_for(60 * ms);
}

/// True where a period makes torque within 400 ms.
bool makes_torque_again(VirtualRig& rig) {
  bool made = false;
  rig.on_period = [&made](const Telemetry<double>& t) { made = made || makes_torque(t.state); };
  rig.run_for(400 * ms);
  rig.on_period = {};
  return made;
}

TEST_P(FaultCampaign, LatchesAndIsLeftByResetDisableEnableAlone) {
  const Injection& injection = GetParam();
  const TorqueCommand<double> disable{.torque_limit = 150.0};
  const TorqueCommand<double> reset{.torque_limit = 150.0, .fault_reset = true};
  const TorqueCommand<double> enable{.torque = 4.0, .torque_limit = 150.0, .enable = true};
  const CampaignCase c = prepared(injection, {.seed = 1, .real_sensors = true});
  SCOPED_TRACE(c.text());
  VirtualRig rig{c.rig};
  ASSERT_TRUE(run_injection(injection, c, rig).raised);
  rig.run_for(400 * ms);  // the cause is gone, also where it is held for some time
  send_only(rig, enable);
  EXPECT_EQ(rig.now().state, DriveState::fault) << "by an enable";
  send_only(rig, disable);
  EXPECT_EQ(rig.now().state, DriveState::fault) << "by a disable";
  send_only(rig, enable);
  EXPECT_EQ(rig.now().state, DriveState::fault) << "by disable, enable";
  EXPECT_TRUE(rig.now().latched.any());
  send_only(rig, reset);
  EXPECT_EQ(rig.now().state, DriveState::standby);
  EXPECT_FALSE(rig.now().latched.any());
  send_only(rig, enable);
  EXPECT_EQ(rig.now().state, DriveState::standby) << "reset, enable: the lockout holds";
  EXPECT_EQ(rig.now().pattern.last_state(), gates_off);
  send_only(rig, disable);
  send_only(rig, enable);
  EXPECT_TRUE(makes_torque_again(rig)) << "after reset, disable, enable";
}

std::vector<Injection> injections_with_limit() {
  std::vector<Injection> list = fault_injections();
  std::erase_if(list, [](const Injection& injection) { return !injection.has_inside; });
  return list;
}

INSTANTIATE_TEST_SUITE_P(Injections, FaultCampaign, ::testing::ValuesIn(fault_injections()), test_name);
INSTANTIATE_TEST_SUITE_P(Injections, FaultLimit, ::testing::ValuesIn(injections_with_limit()), test_name);

bool raises(const std::vector<Injection>& list, Fault fault) {
  return std::ranges::any_of(list, [fault](const Injection& injection) { return injection.fault == fault; });
}

// In the live drive watchdog and overruns are detected by threads, which run the same tasks:
// tests/python/test_live_process.py. Of an open phase tests/safety/protection_test.cpp has the limit.
TEST(FaultCampaignList, HasEveryFaultOfTheContractAndItsLimit) {
  const std::vector<Injection> list = fault_injections();
  const std::vector<Injection> with_limit = injections_with_limit();
  for (int value = 0; value < fault_count; ++value) {
    const auto fault = static_cast<Fault>(value);
    EXPECT_TRUE(raises(list, fault)) << to_string(fault);
    EXPECT_TRUE(raises(with_limit, fault) || fault == Fault::open_phase) << to_string(fault);
  }
}

}  // namespace
}  // namespace sextant::test
