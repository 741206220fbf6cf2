#pragma once

#include <cstddef>
#include <optional>

#include "sextant/plant/appended_pair.hpp"
#include "sextant/plant/conduction_drops.hpp"
#include "sextant/plant/dc_link.hpp"
#include "sextant/plant/driveline.hpp"
#include "sextant/plant/energy_meter.hpp"
#include "sextant/recording/trace_row.hpp"
#include "sextant/run/metrics_sample.hpp"

namespace sextant {

/// The plant's true quantities at one instant of a run, each computed once.
class PlantLook {
 public:
  /// x: a state of the plant. `meter`: index of the energy meter's first state.
  template <class Plant>
  PlantLook(const Plant& plant, const typename Plant::State& x, int meter) noexcept
      : PlantLook{plant.quantities_at(x), plant.drops()} {
    energies.link = x[meter + int(EnergyMeter<>::dc_link)];
    energies.copper =
        x[meter + int(EnergyMeter<>::stator_copper)] + x[meter + int(EnergyMeter<>::rotor_copper)];
    energies.shaft = x[meter + int(EnergyMeter<>::mechanical)];
    energies.field = plant.evaluate(x).field_energy;
    energies.iron = x[meter + int(EnergyMeter<>::iron)];
    using Link = DcLink<>;
    using Shaft = Driveline<>;
    if constexpr (has_part<Link, typename Plant::AppendedType>) {
      const auto y = Plant::template states_of<Link>(x);
      energies.before_link = {y[Link::source], y[Link::resistance], y[Link::chopper],
                              part_of<Link>(plant.appended_system()).stored(y)};
    }
    if constexpr (has_part<Shaft, typename Plant::AppendedType>) {
      const auto y = Plant::template states_of<Shaft>(x);
      const Shaft& shaft = part_of<Shaft>(plant.appended_system());
      energies.behind_shaft = {y[Shaft::friction], y[Shaft::damping], y[Shaft::load],
                               shaft.kinetic_energy(y, omega_m), shaft.elastic_energy(y)};
      load_ = {shaft.torque(y, omega_m), y[Shaft::load_speed]};
      has_driveline_ = true;
    }
  }

  /// For the metrics; instant, references and the link's power are the caller's.
  [[nodiscard]] MetricsSample metrics_sample() const noexcept {
    return {.torque = torque,
            .psi_s = psi_s,
            .i_s = i_s,
            .omega_m = omega_m,
            .energies = energies,
            .load = has_driveline_ ? std::optional{load_} : std::nullopt};
  }

  /// For a trace, with what acts on the plant from outside.
  [[nodiscard]] PlantSample trace_sample(SwitchState state, SpaceVector<> u_s, double tau_l) const noexcept {
    return {.torque = torque,
            .tau_l = tau_l,
            .psi_s = psi_s,
            .psi_r = psi_r,
            .i_abc = inverse_clarke(i_s),
            .u_dc = u_dc,
            .omega_m = omega_m,
            .theta_m = theta_m,
            .i_dc = u_dc > 0 ? power(u_s) / u_dc : 0.0,
            .state = state,
            .u_s = u_s - slope_resistance_ * i_s,
            .i_r = i_r,
            .energies = energies,
            .load = has_driveline_ ? load_ : LoadSample{tau_l, omega_m}};
  }

  /// What the inverter draws from the link, u_dc i_dc: what it passes on and what its thresholds take. u_s:
  /// that of `DrivePlant::u_s` before or after it jumps. [W]
  [[nodiscard]] double power(SpaceVector<> u_s) const noexcept {
    return 1.5 * dot(u_s, i_s) + threshold_loss_;
  }

  SpaceVector<> psi_s, psi_r, i_s, i_r;
  double torque, omega_m, theta_m, u_dc;
  DriveEnergies energies{};

 private:
  PlantLook(const PlantQuantities<>& q, const ConductionDrops<>& drops) noexcept
      : psi_s{q.psi_s},
        psi_r{q.psi_r},
        i_s{q.i_s},
        i_r{q.i_r},
        torque{q.tau_e},
        omega_m{q.omega_m},
        theta_m{q.theta_m},
        u_dc{q.u_dc},
        slope_resistance_{drops.slope_resistance},
        threshold_loss_{drops.threshold_loss(q.i_s)} {}

  double slope_resistance_;    // of the inverter [Ω]
  double threshold_loss_;      // [W]
  LoadSample load_{};          // behind a driveline
  bool has_driveline_{false};  // the plant's load is behind one
};

}  // namespace sextant
