#pragma once

#include <array>
#include <cstdint>

#include "sextant/control/direct_torque_controller.hpp"

namespace sextant {

/// The decisions of direct torque control in continuous time: comparators, sector and switching table of the
/// sampled controller, whose thresholds become event functions. An event is a fall below zero.
///
/// At ψ_s = 0 every sector edge is met at once, so that the sector is held while |ψ_s| is below a mask. It is
/// masked again at half of it.
class ContinuousComparators {
 public:
  /// Torque above and below, flux, lower and upper edge of the sector, mask.
  static constexpr int event_count = 6;
  using Events = std::array<double, event_count>;
  enum Event : int { torque_above, torque_below, flux, sector_lower, sector_upper, mask };

  /// What the comparators compare.
  struct Inputs {
    SpaceVector<> psi_s{};      ///< estimated stator flux linkage [Wb]
    double torque{};            ///< estimated torque [N·m]
    double torque_reference{};  ///< [N·m]
  };

  /// mask_wb: flux below which the sector is held. [Wb]
  ContinuousComparators(const DirectTorqueController<>::Parameters& parameters, double mask_wb) noexcept
      : torque_{parameters.torque_comparator},
        flux_{parameters.flux_comparator},
        sector_{parameters.sector},
        flux_reference_{parameters.flux_reference},
        mask_{mask_wb} {}

  /// The value of every event function; 1 where there is nothing to cross.
  [[nodiscard]] Events events(const Inputs& in) const noexcept {
    return {event(torque_above, in), event(torque_below, in), event(flux, in),
            event(sector_lower, in), event(sector_upper, in), event(mask, in)};
  }

  /// The value of one event function. [N·m for torque, Wb for the others]
  [[nodiscard]] double event(int i, const Inputs& in) const noexcept;

  /// Switches as the event demands, without choosing a new state.
  void on_event(int i, const Inputs& in) noexcept;

  /// Switches until no event function is below zero, and chooses the switching state. True when it changed.
  /// `event`: the one that an engine has just stopped at, or −1; it counts even where its function is zero.
  bool settle(const Inputs& in, int event) noexcept;

  [[nodiscard]] SwitchState state() const noexcept { return state_; }
  [[nodiscard]] int torque_demand() const noexcept { return torque_.output(); }
  [[nodiscard]] bool flux_demand() const noexcept { return flux_.output(); }
  /// Sector of the stator flux, 1…6.
  [[nodiscard]] std::uint8_t sector() const noexcept { return sector_.sector(); }
  /// Times at which the torque comparator has left its zero output, since construction. [-]
  [[nodiscard]] std::int64_t torque_pulses() const noexcept { return torque_pulses_; }

 private:
  /// Larger than the crossings that any jump of the inputs needs: 2 of torque, 1 of flux, 3 edges, the mask.
  static constexpr int max_crossings = 8;

  /// The lowest event function that is below zero, −1 where none is.
  [[nodiscard]] int first_crossed(const Inputs& in) const noexcept;

  TorqueComparator<> torque_;
  FluxComparator<> flux_;
  SectorSelector<> sector_;
  double flux_reference_;  ///< [Wb]
  double mask_;            ///< [Wb]
  bool masked_{true};
  SwitchState state_{switch_states[0]};
  std::int64_t torque_pulses_{0};
};

inline int ContinuousComparators::first_crossed(const Inputs& in) const noexcept {
  for (int i = 0; i < event_count; ++i) {
    if (event(i, in) < 0.0) return i;
  }
  return -1;
}

inline double ContinuousComparators::event(int i, const Inputs& in) const noexcept {
  constexpr double nothing = 1.0;
  switch (i) {
    case torque_above: {
      const double above = torque_.thresholds().above;
      return above < std::numeric_limits<double>::infinity() ? above - (in.torque_reference - in.torque)
                                                             : nothing;
    }
    case torque_below: {
      const double below = torque_.thresholds().below;
      return below > -std::numeric_limits<double>::infinity() ? in.torque_reference - in.torque - below
                                                              : nothing;
    }
    case flux: {
      const double error = flux_reference_ - magnitude(in.psi_s);
      const Thresholds<> t = flux_.thresholds();
      return flux_.output() ? error - t.below : t.above - error;
    }
    case sector_lower:
      return masked_ ? nothing : sector_.thresholds(in.psi_s)[0];
    case sector_upper:
      return masked_ ? nothing : sector_.thresholds(in.psi_s)[1];
    default: {
      const double psi = magnitude(in.psi_s);
      return masked_ ? mask_ - psi : psi - 0.5 * mask_;
    }
  }
}

inline void ContinuousComparators::on_event(int i, const Inputs& in) noexcept {
  switch (i) {
    case torque_above:
    case torque_below:
      torque_.on_crossing(i == torque_above ? 0 : 1);
      torque_pulses_ += torque_.output() != 0 ? 1 : 0;
      break;
    case flux:
      flux_.on_crossing(flux_.output() ? 1 : 0);
      break;
    case sector_lower:
      sector_.on_crossing(0);
      break;
    case sector_upper:
      sector_.on_crossing(1);
      break;
    default:
      masked_ = !masked_;
      if (!masked_) sector_.step(in.psi_s);
      break;
  }
}

inline bool ContinuousComparators::settle(const Inputs& in, int event) noexcept {
  int crossed = event >= 0 ? event : first_crossed(in);
  for (int crossings = 0; crossed >= 0 && crossings < max_crossings; ++crossings) {
    on_event(crossed, in);
    crossed = first_crossed(in);
  }
  const SwitchState next = select_state(sector_.sector(), flux_.output(), torque_.output(), state_);
  const bool changed = next != state_;
  state_ = next;
  return changed;
}

}  // namespace sextant
