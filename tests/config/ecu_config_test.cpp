#include "sextant/config/ecu_config.hpp"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"

namespace sextant {
namespace {

/// Why the shipped file is refused with these changes; empty when it is not.
std::string refusal(const std::vector<std::string>& overrides) {
  try {
    (void)load_ecu_config(shipped_ecu, overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

TEST(EcuConfig, TheWatchdogMustOutlastTwoWakeUps) {
  EXPECT_NE(refusal({"realtime.watchdog_ms=1.99"}).find("watchdog_ms is too short"), std::string::npos);
  EXPECT_EQ(refusal({"realtime.watchdog_ms=2"}), "");
  EXPECT_NE(refusal({"realtime.wake_every_periods=1001", "command.timeout_ms=60"}), "");
  EXPECT_EQ(refusal({"realtime.wake_every_periods=1000", "command.timeout_ms=60"}), "");
  EXPECT_NE(refusal({"drive.period_us=10000", "command.timeout_ms=1000", "command.lost_ms=2000"}), "");
}

TEST(EcuConfig, ACommandMustNotTimeOutBetweenTwoWakeUps) {
  EXPECT_EQ(refusal({"realtime.wake_every_periods=1600", "realtime.watchdog_ms=100"}),
            "--set: realtime: wake_every_periods is too large: these control periods take longer than "
            "command.timeout_ms");
  EXPECT_EQ(refusal({"realtime.wake_every_periods=1599", "realtime.watchdog_ms=100"}), "");
}

TEST(EcuConfig, AnIdentifierOffsetMovesWholeBlocks) {
  EXPECT_EQ(load_ecu_config(shipped_ecu, {"can.identifier_offset=1728"}).can.identifier_offset.value, 1728);
  EXPECT_EQ(refusal({"can.identifier_offset=48"}),
            "--set: can: identifier_offset must be a multiple of 32, so that no two drives overlap");
  EXPECT_NE(refusal({"can.identifier_offset=1760"}).find("can.identifier_offset: expected "),
            std::string::npos);
}

TEST(EcuConfig, DeadlineSchedulingHasToFit) {
  const std::string policy = "realtime.policy=deadline";
  EXPECT_EQ(refusal({policy}), "");
  EXPECT_EQ(refusal({policy, "realtime.deadline_runtime_us=1000"}), "");
  EXPECT_NE(refusal({policy, "realtime.deadline_runtime_us=1000.1"}).find("deadline_runtime_us is too long"),
            std::string::npos);
  EXPECT_EQ(refusal({"realtime.deadline_runtime_us=1000.1"}), "") << "not in force";
  EXPECT_NE(refusal({policy, "realtime.wait=spin"}).find("uses up the time"), std::string::npos);
  EXPECT_NE(refusal({policy, "realtime.cpu=1"}).find("exclude each other"), std::string::npos);
  EXPECT_NE(refusal({"command.timeout_ms=1"}).find("wake_every_periods is too large"), std::string::npos);
}

TEST(EcuConfig, HybridWaitingHasToSleep) {
  EXPECT_EQ(refusal({"realtime.wait=hybrid", "realtime.spin_margin_us=999.9"}), "");
  EXPECT_NE(
      refusal({"realtime.wait=hybrid", "realtime.spin_margin_us=1000"}).find("spin_margin_us is too long"),
      std::string::npos);
  EXPECT_EQ(refusal({"realtime.wait=spin", "realtime.spin_margin_us=1000"}), "");
}

}  // namespace
}  // namespace sextant
