#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "sextant/plant/inverter_losses.hpp"

namespace sextant {

/// Readings of a DC link whose voltage is a state (`DcLink`), at one instant. [J]
struct LinkEnergies {
  double source{};       ///< delivered by the source
  double source_loss{};  ///< lost in the source's resistance
  double chopper{};      ///< lost in the brake chopper
  double stored{};       ///< in the capacitor and the source's inductance

  friend LinkEnergies operator+(const LinkEnergies& a, const LinkEnergies& b) noexcept {
    return {a.source + b.source, a.source_loss + b.source_loss, a.chopper + b.chopper, a.stored + b.stored};
  }
  friend LinkEnergies operator-(const LinkEnergies& a, const LinkEnergies& b) noexcept {
    return {a.source - b.source, a.source_loss - b.source_loss, a.chopper - b.chopper, a.stored - b.stored};
  }
};

/// Readings of a load behind a driveline (`Driveline`), at one instant. [J]
struct DrivelineEnergies {
  double friction{};  ///< lost in the motor's viscous friction
  double damping{};   ///< lost in the damping of the shaft
  double load{};      ///< work on load torque and road load
  double kinetic{};   ///< of the inertias of motor and load
  double elastic{};   ///< in the twist of the shaft

  friend DrivelineEnergies operator+(const DrivelineEnergies& a, const DrivelineEnergies& b) noexcept {
    return {a.friction + b.friction, a.damping + b.damping, a.load + b.load, a.kinetic + b.kinetic,
            a.elastic + b.elastic};
  }
  friend DrivelineEnergies operator-(const DrivelineEnergies& a, const DrivelineEnergies& b) noexcept {
    return {a.friction - b.friction, a.damping - b.damping, a.load - b.load, a.kinetic - b.kinetic,
            a.elastic - b.elastic};
  }
};

/// From a reading to a later one; empty where one of them is.
template <class Energies>
[[nodiscard]] std::optional<Energies> energy_change(const std::optional<Energies>& from,
                                                    const std::optional<Energies>& to) noexcept {
  if (!from || !to) return std::nullopt;
  return *to - *from;
}
/// Adds a change; an empty one adds nothing.
template <class Energies>
void add_energies(std::optional<Energies>& sum, const std::optional<Energies>& change) noexcept {
  if (!change) [[likely]]
    return;
  sum = sum ? *sum + *change : *change;
}

/// Readings of the plant's energy meter, and the energy of its field, at one instant. NaN: not known. [J]
struct DriveEnergies {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  double link{unknown};    ///< drawn from the DC link, with what the inverter loses beyond its drops
  double copper{unknown};  ///< lost in the windings, and in the inverter's switches and diodes
  double shaft{unknown};   ///< work of the air-gap torque
  double field{unknown};   ///< stored in the magnetic field
  double iron{unknown};    ///< lost in the iron
  std::optional<LinkEnergies> before_link{};        ///< empty where the link is stiff
  std::optional<DrivelineEnergies> behind_shaft{};  ///< empty where the load is on the motor's shaft
  std::optional<InverterEnergies> inverter{};       ///< empty where losses by curves are not known
};

/// Energies that have flowed over a segment of a run, or over the share of one. An unknown reading makes its
/// own energy NaN and no other. [J]
struct EnergyFlow {
  double net_link{};    ///< out of the link, less what went back
  double gross_link{};  ///< across the link, either way
  double shaft{};       ///< net work of the torque
  double copper{};
  double field{};  ///< change of the field's energy
  double iron{};
  std::optional<LinkEnergies> before_link{};        ///< empty where the link is stiff
  std::optional<DrivelineEnergies> behind_shaft{};  ///< empty where the load is on the motor's shaft
  std::optional<InverterEnergies> inverter{};       ///< empty where losses by curves are not known

  /// Between two readings of the meter, over which the link's power runs linearly from power_a to power_b
  /// [W].
  [[nodiscard]] static EnergyFlow between(const DriveEnergies& a, const DriveEnergies& b, double power_a,
                                          double power_b, double seconds) noexcept {
    const double net = b.link - a.link;
    return {.net_link = net,
            .gross_link = gross(net, power_a, power_b, seconds),
            .shaft = b.shaft - a.shaft,
            .copper = b.copper - a.copper,
            .field = b.field - a.field,
            .iron = b.iron - a.iron,
            .before_link = energy_change(a.before_link, b.before_link),
            .behind_shaft = energy_change(a.behind_shaft, b.behind_shaft),
            .inverter = energy_change(a.inverter, b.inverter)};
  }

  EnergyFlow& operator+=(const EnergyFlow& o) noexcept {
    net_link += o.net_link;
    gross_link += o.gross_link;
    shaft += o.shaft;
    copper += o.copper;
    field += o.field;
    iron += o.iron;
    add_energies(before_link, o.before_link);
    add_energies(behind_shaft, o.behind_shaft);
    add_energies(inverter, o.inverter);
    return *this;
  }

 private:
  // What has crossed the link, either way, along a line of power from a to b; never less than the net, which
  // is known better.
  static double gross(double net, double a, double b, double seconds) noexcept {
    const double least = std::abs(net) + 0 * (a + b);  // NaN where a power is
    if (!(a * b < 0)) return least;
    return std::max(least, 0.5 * seconds * (a * a + b * b) / (std::abs(a) + std::abs(b)));
  }
};

/// Adds up the energies of a run. Energy out of the link and energy back into it are separated by the sign of
/// the link's power.
class EnergyAccount {
 public:
  void add(const EnergyFlow& flow) noexcept { sum_ += flow; }

  /// Integral of the positive part of the link's power. [J]
  [[nodiscard]] double from_link() const noexcept { return 0.5 * (sum_.gross_link + sum_.net_link); }
  /// Integral of the negative part of the link's power, as a positive number. [J]
  [[nodiscard]] double to_link() const noexcept { return 0.5 * (sum_.gross_link - sum_.net_link); }
  /// Net work of the torque. [J]
  [[nodiscard]] double shaft() const noexcept { return sum_.shaft; }
  [[nodiscard]] double copper() const noexcept { return sum_.copper; }  ///< [J]
  [[nodiscard]] double iron() const noexcept { return sum_.iron; }      ///< [J]
  /// Change of the field's energy. [J]
  [[nodiscard]] double field() const noexcept { return sum_.field; }

  /// What has flowed before a link whose voltage is a state; empty where the link is stiff. [J]
  [[nodiscard]] const std::optional<LinkEnergies>& before_link() const noexcept { return sum_.before_link; }
  /// What the shaft's work has become behind a driveline; empty where the load is on the motor's shaft. [J]
  [[nodiscard]] const std::optional<DrivelineEnergies>& behind_shaft() const noexcept {
    return sum_.behind_shaft;
  }

  /// What the inverter has lost by curves; empty where that is not known. [J]
  [[nodiscard]] const std::optional<InverterEnergies>& inverter() const noexcept { return sum_.inverter; }
  /// Out of the link, less what went back. [J]
  [[nodiscard]] double net_link() const noexcept { return sum_.net_link; }

  /// What the balances  link = shaft + copper + iron + field + what the inverter has drawn  and, where the
  /// link is not stiff, source = source_loss + chopper + stored + link  and, behind a driveline, shaft =
  /// friction + damping + load + kinetic + elastic  leave over, as a share of all that has flowed: across the
  /// link either way, into the shaft, the windings, the iron and the field, before the link, and behind the
  /// shaft; 0 where next to nothing has. [-]
  [[nodiscard]] double unaccounted() const noexcept {
    constexpr double nothing_j = 1e-6;
    const EnergyFlow& f = sum_;
    double all = f.gross_link + std::abs(f.shaft) + std::abs(f.copper) + std::abs(f.field) + std::abs(f.iron);
    double rest = f.net_link - f.shaft - f.copper - f.field - f.iron;
    if (f.inverter) {
      all += std::abs(f.inverter->drawn);
      rest -= f.inverter->drawn;
    }
    double left = std::abs(rest);
    if (f.before_link) {
      const auto& [source, source_loss, chopper, stored] = *f.before_link;
      all += std::abs(source) + source_loss + chopper + std::abs(stored);
      left += std::abs(source - source_loss - chopper - stored - f.net_link);
    }
    if (f.behind_shaft) {
      const auto& [friction, damping, load, kinetic, elastic] = *f.behind_shaft;
      all += friction + std::abs(damping) + std::abs(load) + std::abs(kinetic) + std::abs(elastic);
      left += std::abs(f.shaft - friction - damping - load - kinetic - elastic);
    }
    return all < nothing_j ? 0.0 : left / all;
  }

 private:
  EnergyFlow sum_{};
};

}  // namespace sextant
