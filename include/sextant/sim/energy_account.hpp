#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace sextant {

/// Readings of the plant's energy meter, and the energy of its field, at one instant. NaN: not known. [J]
struct DriveEnergies {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  double link{unknown};    ///< drawn from the DC link
  double copper{unknown};  ///< lost in the windings, and in the inverter's switches and diodes
  double shaft{unknown};   ///< work of the air-gap torque
  double field{unknown};   ///< stored in the magnetic field
  double iron{unknown};    ///< lost in the iron
};

/// Adds up energies over segments of a run, from the readings of a meter that is integrated with the plant.
/// Energy out of the link and energy back into it are separated by the sign of the link's power, which is
/// linear between the ends of a segment. An unknown reading makes its own energy NaN and no other.
class EnergyAccount {
 public:
  /// Readings of the meter and powers of the link [W] at both ends of a segment, or of the share of one.
  void add(const DriveEnergies& a, const DriveEnergies& b, double power_a, double power_b,
           double seconds) noexcept {
    const double net = b.link - a.link;
    net_link_ += net;
    gross_link_ += gross(net, power_a, power_b, seconds);
    shaft_ += b.shaft - a.shaft;
    copper_ += b.copper - a.copper;
    field_ += b.field - a.field;
    iron_ += b.iron - a.iron;
  }

  /// Integral of the positive part of the link's power. [J]
  [[nodiscard]] double from_link() const noexcept { return 0.5 * (gross_link_ + net_link_); }
  /// Integral of the negative part of the link's power, as a positive number. [J]
  [[nodiscard]] double to_link() const noexcept { return 0.5 * (gross_link_ - net_link_); }
  /// Net work of the torque. [J]
  [[nodiscard]] double shaft() const noexcept { return shaft_; }
  [[nodiscard]] double copper() const noexcept { return copper_; }  ///< [J]
  [[nodiscard]] double iron() const noexcept { return iron_; }      ///< [J]
  /// Change of the field's energy. [J]
  [[nodiscard]] double field() const noexcept { return field_; }

  /// What the balance  link = shaft + copper + iron + field  leaves over, as a share of all that has flowed:
  /// across the link either way, into the shaft, the windings, the iron and the field; 0 where next to
  /// nothing has. [-]
  [[nodiscard]] double unaccounted() const noexcept {
    constexpr double nothing_j = 1e-6;
    const double sum =
        gross_link_ + std::abs(shaft_) + std::abs(copper_) + std::abs(field_) + std::abs(iron_);
    if (sum < nothing_j) return 0;
    return std::abs(net_link_ - shaft_ - copper_ - field_ - iron_) / sum;
  }

 private:
  // What has crossed the link, either way, along a line of power from a to b; never less than the net, which
  // is known better.
  static double gross(double net, double a, double b, double seconds) noexcept {
    const double least = std::abs(net) + 0 * (a + b);  // NaN where a power is
    if (!(a * b < 0)) return least;
    return std::max(least, 0.5 * seconds * (a * a + b * b) / (std::abs(a) + std::abs(b)));
  }

  double net_link_{};
  double gross_link_{};
  double shaft_{};
  double copper_{};
  double field_{};
  double iron_{};
};

}  // namespace sextant
