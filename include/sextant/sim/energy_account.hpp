#pragma once

#include <cmath>

namespace sextant {

/// Powers at the boundaries of the drive at one instant.
struct DrivePowers {
  double link{};    ///< drawn from the DC link [W]
  double copper{};  ///< lost in the windings [W]
  double torque{};  ///< air-gap torque [N·m]
  double speed{};   ///< mechanical [rad/s]
};

/// Integrates the powers of a drive. An unknown power, NaN, makes its own energies NaN and no other.
class EnergyAccount {
 public:
  /// A control period, over which the link's power is `b.link` and the rest follows the trapezoidal rule.
  void add_period(const DrivePowers& a, const DrivePowers& b, double seconds) noexcept {
    net_link_ += seconds * b.link;
    gross_link_ += seconds * std::abs(b.link);
    shaft_ += 0.5 * seconds * (a.torque * a.speed + b.torque * b.speed);
    copper_ += 0.5 * seconds * (a.copper + b.copper);
  }

  /// A segment over which link power, torque and speed run linearly. The copper losses, which are quadratic
  /// there, follow the trapezoidal rule.
  void add_segment(const DrivePowers& a, const DrivePowers& b, double seconds) noexcept {
    net_link_ += 0.5 * seconds * (a.link + b.link);
    gross_link_ += 0.5 * seconds * gross(a.link, b.link);
    shaft_ += seconds / 6 * (a.torque * (2 * a.speed + b.speed) + b.torque * (a.speed + 2 * b.speed));
    copper_ += 0.5 * seconds * (a.copper + b.copper);
  }

  /// Integral of the positive part of the link's power. [J]
  [[nodiscard]] double from_link() const noexcept { return 0.5 * (gross_link_ + net_link_); }
  /// Integral of the negative part of the link's power, as a positive number. [J]
  [[nodiscard]] double to_link() const noexcept { return 0.5 * (gross_link_ - net_link_); }
  /// Net work of the torque. [J]
  [[nodiscard]] double shaft() const noexcept { return shaft_; }
  [[nodiscard]] double copper() const noexcept { return copper_; }  ///< [J]

 private:
  // Twice the mean magnitude of the line from a to b.
  static double gross(double a, double b) noexcept {
    const double sum = std::abs(a) + std::abs(b);
    return a * b < 0 ? (a * a + b * b) / sum : sum;
  }

  double net_link_{};
  double gross_link_{};
  double shaft_{};
  double copper_{};
};

}  // namespace sextant
