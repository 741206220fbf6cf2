#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "sextant/core/space_vector.hpp"
#include "sextant/recording/energy_account.hpp"
#include "sextant/recording/load_sample.hpp"

namespace sextant {

/// The true state of drive and plant at one instant; the plant's values, not the estimator's.
///
/// What is NaN by default is unknown unless given; the metrics that need it are NaN then.
struct MetricsSample {
  std::int64_t t_ns{};        ///< from the beginning of the run [ns]
  double torque_reference{};  ///< [N·m]
  double torque{};            ///< air-gap torque [N·m]
  SpaceVector<> psi_s{};      ///< stator flux linkage, stationary frame [Wb]
  SpaceVector<> i_s{};        ///< stator current, stationary frame [A]
  double omega_m{};           ///< mechanical speed [rad/s]
  double fraction_ns{};       ///< of a nanosecond by which the instant is later than t_ns [ns]
  double p_dc{std::numeric_limits<double>::quiet_NaN()};             ///< drawn from the DC link [W]
  DriveEnergies energies{};                                          ///< read from the plant's meter
  double speed_reference{std::numeric_limits<double>::quiet_NaN()};  ///< mechanical [rad/s]
  std::optional<LoadSample> load{};                                  ///< behind a driveline

  /// Time since `origin_ns`, exact to 1e-7 ns within a second of it. [ns]
  [[nodiscard]] constexpr double since(std::int64_t origin_ns) const noexcept {
    return double(t_ns - origin_ns) + fraction_ns;
  }
};

}  // namespace sextant
