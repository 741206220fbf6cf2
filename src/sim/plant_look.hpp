#pragma once

#include "sextant/plant/energy_meter.hpp"
#include "sextant/plant/induction_machine.hpp"
#include "sextant/sim/metrics_sample.hpp"
#include "sextant/sim/segment_log.hpp"
#include "sextant/sim/trace_row.hpp"

namespace sextant {

/// The plant's true quantities at one instant of a run, each computed once.
class PlantLook {
 public:
  /// `meter`: index of the energy meter's first state.
  template <class Plant>
  PlantLook(const InductionMachine<double>& machine, const PlantInstant<Plant>& now, int meter) noexcept
      : psi_s{now.x[Plant::psi_s_alpha], now.x[Plant::psi_s_beta]},
        psi_r{now.x[Plant::psi_r_alpha], now.x[Plant::psi_r_beta]},
        i_s{machine.stator_current(psi_s, psi_r)},
        i_r{machine.rotor_current(psi_s, psi_r)},
        u_s{now.u_s},
        torque{machine.torque(psi_s, i_s)},
        omega_m{now.x[Plant::omega]},
        theta_m{now.x[Plant::theta]},
        i_dc{now.i_dc},
        energies{.link = now.x[meter + int(EnergyMeter<>::dc_link)],
                 .copper = now.x[meter + int(EnergyMeter<>::stator_copper)] +
                           now.x[meter + int(EnergyMeter<>::rotor_copper)],
                 .shaft = now.x[meter + int(EnergyMeter<>::mechanical)],
                 .field = 0.75 * (dot(psi_s, i_s) + dot(psi_r, i_r))} {}

  /// For the metrics; instant and references are the caller's.
  [[nodiscard]] MetricsSample metrics_sample(double u_dc) const noexcept {
    return {.torque = torque,
            .psi_s = psi_s,
            .i_s = i_s,
            .omega_m = omega_m,
            .p_dc = u_dc * i_dc,
            .energies = energies};
  }

  /// For a trace, with what acts on the plant from outside.
  [[nodiscard]] PlantSample trace_sample(SwitchState state, double u_dc, double tau_l) const noexcept {
    return {.torque = torque,
            .tau_l = tau_l,
            .psi_s = psi_s,
            .psi_r = psi_r,
            .i_abc = inverse_clarke(i_s),
            .u_dc = u_dc,
            .omega_m = omega_m,
            .theta_m = theta_m,
            .i_dc = i_dc,
            .state = state,
            .u_s = u_s,
            .i_r = i_r,
            .energies = energies};
  }

  SpaceVector<> psi_s, psi_r, i_s, i_r, u_s;
  double torque, omega_m, theta_m, i_dc;
  DriveEnergies energies;
};

}  // namespace sextant
