#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace sextant {

/// Readings of a DC link whose voltage is a state (`DcLink`), at one instant. [J]
struct LinkEnergies {
  double source{};       ///< delivered by the source
  double source_loss{};  ///< lost in the source's resistance
  double chopper{};      ///< lost in the brake chopper
  double stored{};       ///< in the capacitor and the source's inductance
};

/// Readings of the plant's energy meter, and the energy of its field, at one instant. NaN: not known. [J]
struct DriveEnergies {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  double link{unknown};    ///< drawn from the DC link
  double copper{unknown};  ///< lost in the windings, and in the inverter's switches and diodes
  double shaft{unknown};   ///< work of the air-gap torque
  double field{unknown};   ///< stored in the magnetic field
  double iron{unknown};    ///< lost in the iron
  std::optional<LinkEnergies> before_link{};  ///< empty where the link is stiff
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
    if (a.before_link && b.before_link) add(*a.before_link, *b.before_link);
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

  /// What has flowed before a link whose voltage is a state; empty where the link is stiff. [J]
  [[nodiscard]] const std::optional<LinkEnergies>& before_link() const noexcept { return before_link_; }

  /// What the balances  link = shaft + copper + iron + field  and, where the link is not stiff,
  /// source = source_loss + chopper + stored + link  leave over, as a share of all that has flowed: across
  /// the link either way, into the shaft, the windings, the iron and the field, and before the link; 0 where next to
  /// nothing has. [-]
  [[nodiscard]] double unaccounted() const noexcept {
    constexpr double nothing_j = 1e-6;
    double sum = gross_link_ + std::abs(shaft_) + std::abs(copper_) + std::abs(field_) + std::abs(iron_);
    double left = std::abs(net_link_ - shaft_ - copper_ - field_ - iron_);
    if (before_link_) {
      const auto& [source, source_loss, chopper, stored] = *before_link_;
      sum += std::abs(source) + source_loss + chopper + std::abs(stored);
      left += std::abs(source - source_loss - chopper - stored - net_link_);
    }
    if (sum < nothing_j) return 0;
    return left / sum;
  }

 private:
  void add(const LinkEnergies& a, const LinkEnergies& b) noexcept {
    if (!before_link_) before_link_.emplace();
    before_link_->source += b.source - a.source;
    before_link_->source_loss += b.source_loss - a.source_loss;
    before_link_->chopper += b.chopper - a.chopper;
    before_link_->stored += b.stored - a.stored;
  }

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
  std::optional<LinkEnergies> before_link_{};
};

}  // namespace sextant
