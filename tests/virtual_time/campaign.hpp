#pragma once

#include <cstdint>

#include <gtest/gtest.h>

#include "virtual_time/campaign_case.hpp"

namespace sextant::test {

/// Runs `body` for so many seeds, with the case in every message of a failure.
template <class Body>
void for_seeds(std::uint64_t count, Body&& body) {
  for (std::uint64_t seed = 1; seed <= count; ++seed) {
    CampaignCase c{seed};
    SCOPED_TRACE(c.text());
    body(c);
    if (::testing::Test::HasFatalFailure()) return;
  }
}

/// Watches a drive that ought not to notice: torque reference as it was, gates on, no fault.
class HoldsSetpoint {
 public:
  explicit HoldsSetpoint(VirtualRig& rig) : rig_{rig}, reference_{rig.now().torque_reference} {
    rig_.on_period = [this](const Telemetry<double>& t) {
      held_ = held_ && t.torque_reference == reference_ && t.state == DriveState::torque && !t.latched.any();
    };
  }
  ~HoldsSetpoint() { rig_.on_period = {}; }
  HoldsSetpoint(const HoldsSetpoint&) = delete;
  HoldsSetpoint& operator=(const HoldsSetpoint&) = delete;
  [[nodiscard]] bool held() const { return held_; }

 private:
  VirtualRig& rig_;
  double reference_;
  bool held_{true};
};

}  // namespace sextant::test
