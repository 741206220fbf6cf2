#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sextant/profiles/profile.hpp"

namespace sextant {

/// The passive load of an electric vehicle: two look-up tables over the vehicle's speed, one for the torque
/// reference of the motor and one for the speed at which its wheel turns, which is imposed on it.
/// Source: paper, 3.5 and Table 5 (steady states of a vehicle under constant torque).
///
/// Between its rows a table is linear. Beyond them `extrapolation` determines the torque. The wheel
/// speed follows the kinematics: below the first row it is proportional to the vehicle's speed,
/// so that the wheel is at rest when the vehicle is, and above the last row it prolongs the last two rows,
/// whatever the torque does.
class PassiveEvLoad {
 public:
  /// A steady state.
  struct Row {
    double speed{};        ///< of the vehicle [m/s]
    double torque{};       ///< of the motor [N·m]
    double wheel_speed{};  ///< mechanical [rad/s]
    friend constexpr bool operator==(const Row&, const Row&) noexcept = default;
  };
  /// The torque beyond the rows of the table.
  enum class Extrapolation : std::uint8_t {
    linear,  ///< the line through the first two and through the last two rows goes on: below zero at rest
    clip,    ///< the first and the last torque are held
    origin   ///< from zero at rest straight to the first row; above the last as linear
  };
  struct Parameters {
    std::vector<Row> rows{};  ///< at least two, the speed above zero and rising
    Extrapolation extrapolation{Extrapolation::linear};

    /// Empty when usable, else what is wrong and in which row (from 0).
    [[nodiscard]] std::string validate() const;
  };
  /// Torque reference and wheel speed of a drive cycle.
  struct Profiles {
    ProfileParameters torque{};       ///< torque reference [N·m]
    ProfileParameters wheel_speed{};  ///< imposed speed [rad/s]
  };

  /// Throws std::runtime_error with the sentence of `validate()`.
  explicit PassiveEvLoad(const Parameters& parameters);

  /// Torque at a vehicle speed of 0 or more. [m/s] → [N·m]
  [[nodiscard]] double torque(double speed) const noexcept;

  /// Wheel speed at a vehicle speed of 0 or more. [m/s] → [rad/s]
  [[nodiscard]] double wheel_speed(double speed) const noexcept;

  /// Both tables along a vehicle speed [m/s] given as a list of lines. A piecewise-linear function of a
  /// piecewise-linear speed is one itself: it gets corners where the speed crosses a row, to the nanosecond.
  [[nodiscard]] Profiles along(const ProfileParameters& speed) const;

 private:
  [[nodiscard]] double looked_up(double speed, double Row::* column, double slope_below,
                                 double slope_above) const noexcept;
  /// Times between two points of a speed at which it crosses rows, in order. [s]
  [[nodiscard]] std::vector<ProfilePoint> crossings(ProfilePoint from, ProfilePoint to) const;

  std::vector<Row> rows_;
  double torque_slope_below_{};  ///< [N·m·s/m]
  double torque_slope_above_{};  ///< [N·m·s/m]
  double wheel_slope_below_{};   ///< [rad/m]
  double wheel_slope_above_{};   ///< [rad/m]
};

/// The rows of a table, from a CSV file with the columns `torque_nm`, `vehicle_speed_kmh` and
/// `wheel_speed_rpm`. Throws std::runtime_error with one sentence that names file, line and column.
[[nodiscard]] std::vector<PassiveEvLoad::Row> read_passive_ev_table(const std::string& file);

}  // namespace sextant
