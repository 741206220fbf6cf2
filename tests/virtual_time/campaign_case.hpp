#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <string>

#include <fmt/format.h>

#include "virtual_time/virtual_rig.hpp"

namespace sextant::test {

/// One case of a campaign: an operating point and an instant, drawn from a seed.
struct CampaignCase {
  explicit CampaignCase(std::uint64_t s) : seed{s}, dice{s} {
    constexpr std::array torques{-40.0, -15.0, -4.0, 4.0, 15.0, 40.0};
    constexpr std::array speeds{-80.0, -40.0, 0.0, 40.0, 80.0};
    rig.torque = torques[std::size_t(between(0, torques.size() - 1))];
    rig.omega_m = speeds[std::size_t(between(0, speeds.size() - 1))];
    rig.wake_every_periods = between(0, 1) == 0 ? 1 : 40;
    rig.vehicle.first_ns = between(0, 9'999) * 1000;
    rig.vehicle.first_counter = std::uint8_t(between(0, 14));
    at_ns = 201 * ms + between(0, 19'999) * 1000;
  }

  /// Even, both ends included.
  std::int64_t between(std::int64_t lowest, std::int64_t highest) {
    return lowest + std::int64_t(dice() % std::uint64_t(highest - lowest + 1));
  }

  [[nodiscard]] std::int64_t wake_ns() const {
    return std::int64_t{rig.wake_every_periods} * VirtualRig::period_ns;
  }
  [[nodiscard]] std::string text() const {
    return fmt::format("seed {}: {} N·m at {} rad/s, {} periods a wake-up, fault at {} ns", seed, rig.torque,
                       rig.omega_m, rig.wake_every_periods, at_ns);
  }

  std::uint64_t seed;
  std::mt19937_64 dice;
  VirtualRigParameters rig{};
  std::int64_t at_ns{};                  ///< when the fault comes, after 200 ms of hand-shake and torque [ns]
  std::optional<double> start_torque{};  ///< until then; empty: that of the rig [N·m]
  bool just_inside{false};               ///< the cause stays just inside the limit of its rule
};

}  // namespace sextant::test
