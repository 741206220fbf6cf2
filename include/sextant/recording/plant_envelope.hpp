#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "sextant/recording/trace_row.hpp"

namespace sextant {

/// Reduces the plant's values of an interval to one row: minimum and maximum of torque, flux and current,
/// so that no peak between two rows is lost, the mean of torque and flux, and the last value of the rest.
///
/// The values are those of the ends of segments, over which they run linearly and which weigh by their
/// duration. An interval without any is that of one instant. A NaN makes the mean NaN and leaves minimum and
/// maximum to the numbers.
class PlantEnvelope {
 public:
  /// Adds a segment, which begins where the one before ended: the plant's state does not jump.
  void add_segment(const PlantSample& before, const PlantSample& after, double seconds) noexcept {
    if (weight_ == 0) last_flux_ = include(before);
    const double flux = include(after);
    weight_ += seconds;
    torque_sum_ += 0.5 * seconds * (before.torque + after.torque);
    flux_sum_ += 0.5 * seconds * (last_flux_ + flux);
    last_flux_ = flux;
  }

  /// The interval so far, which ends with `last`.
  [[nodiscard]] PlantRow row(const PlantSample& last) const noexcept {
    if (weight_ == 0) {
      PlantEnvelope instant;
      instant.add_segment(last, last, 1);
      return instant.row(last);
    }
    return {.torque_nm = last.torque,
            .torque_mean_nm = torque_sum_ / weight_,
            .torque_min_nm = torque_.lowest(),
            .torque_max_nm = torque_.highest(),
            .psi_s_wb = magnitude(last.psi_s),
            .flux_mean_wb = flux_sum_ / weight_,
            .flux_min_wb = flux_.lowest(),
            .flux_max_wb = flux_.highest(),
            .psi_s_alpha_wb = last.psi_s.alpha,
            .psi_s_beta_wb = last.psi_s.beta,
            .psi_r_alpha_wb = last.psi_r.alpha,
            .psi_r_beta_wb = last.psi_r.beta,
            .current_min_a = std::sqrt(current_squared_.lowest()),
            .current_max_a = std::sqrt(current_squared_.highest()),
            .i_a_a = last.i_abc.a,
            .i_b_a = last.i_abc.b,
            .i_c_a = last.i_abc.c,
            .u_dc_v = last.u_dc,
            .omega_m_rad_s = last.omega_m,
            .tau_l_nm = last.tau_l,
            .theta_m_rad = last.theta_m,
            .shaft_torque_nm = last.load.shaft_torque,
            .load_speed_rad_s = last.load.speed,
            .i_dc_a = last.i_dc,
            .u_s_alpha_v = last.u_s.alpha,
            .u_s_beta_v = last.u_s.beta,
            .i_r_alpha_a = last.i_r.alpha,
            .i_r_beta_a = last.i_r.beta,
            .energy_link_j = last.energies.link,
            .energy_copper_j = last.energies.copper,
            .energy_iron_j = last.energies.iron,
            .energy_shaft_j = last.energies.shaft,
            .energy_field_j = last.energies.field,
            .winding_temperature_c = last.temperatures.winding,
            .rotor_temperature_c = last.temperatures.rotor,
            .housing_temperature_c = last.temperatures.housing,
            .energy_inverter_j = last.energies.inverter ? last.energies.inverter->drawn : 0.0,
            .inverter_loss_w = last.inverter.loss,
            .case_temperature_c = last.inverter.case_temperature,
            .junction_a_upper_switch_c = last.inverter.junctions[0],
            .junction_a_upper_diode_c = last.inverter.junctions[1],
            .junction_a_lower_switch_c = last.inverter.junctions[2],
            .junction_a_lower_diode_c = last.inverter.junctions[3],
            .junction_b_upper_switch_c = last.inverter.junctions[4],
            .junction_b_upper_diode_c = last.inverter.junctions[5],
            .junction_b_lower_switch_c = last.inverter.junctions[6],
            .junction_b_lower_diode_c = last.inverter.junctions[7],
            .junction_c_upper_switch_c = last.inverter.junctions[8],
            .junction_c_upper_diode_c = last.inverter.junctions[9],
            .junction_c_lower_switch_c = last.inverter.junctions[10],
            .junction_c_lower_diode_c = last.inverter.junctions[11],
            .switch_a = leg(last.state.a()),
            .switch_b = leg(last.state.b()),
            .switch_c = leg(last.state.c())};
  }

  /// Begins the next interval.
  void reset() noexcept { *this = {}; }

 private:
  struct Limits {
    double min{std::numeric_limits<double>::infinity()};
    double max{-std::numeric_limits<double>::infinity()};

    void include(double x) noexcept {
      min = x < min ? x : min;
      max = x > max ? x : max;
    }
    // Infinite limits are left only where no value was a number.
    [[nodiscard]] double lowest() const noexcept {
      return min > max ? std::numeric_limits<double>::quiet_NaN() : min;
    }
    [[nodiscard]] double highest() const noexcept {
      return min > max ? std::numeric_limits<double>::quiet_NaN() : max;
    }
  };

  static std::int8_t leg(LegState state) noexcept {
    if (state == LegState::off) return -1;
    return state == LegState::high ? 1 : 0;
  }

  // Returns the magnitude of the flux.
  double include(const PlantSample& sample) noexcept {
    const SpaceVector<> i_s = clarke(sample.i_abc);
    const double psi = magnitude(sample.psi_s);
    torque_.include(sample.torque);
    flux_.include(psi);
    current_squared_.include(dot(i_s, i_s));
    return psi;
  }

  double weight_{0};
  double torque_sum_{0};
  double flux_sum_{0};
  double last_flux_{0};  // at the end of the last segment [Wb]
  Limits torque_{};
  Limits flux_{};
  Limits current_squared_{};
};

}  // namespace sextant
