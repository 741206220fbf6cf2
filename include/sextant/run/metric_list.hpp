#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

namespace sextant {

/// The metrics of a run, in the order of display.
enum class Metric : std::uint8_t {
  torque_ripple_pp,
  torque_ripple_rms,
  torque_bias,
  torque_error_rms,
  torque_error_max,
  torque_deviation,
  torque_silent,
  torque_motoring,
  torque_regenerating,
  response_time,
  flux_mean,
  flux_min,
  flux_max,
  switching_frequency,
  torque_pulse_frequency,
  dwell_limited,
  short_pulses,
  peak_current,
  current_thd,
  energy_from_link,
  energy_to_link,
  energy_shaft,
  energy_copper,
  energy_iron,
  energy_field,
  energy_inverter,
  energy_source,
  energy_source_loss,
  energy_chopper,
  energy_stored,
  energy_friction,
  energy_damping,
  energy_load,
  energy_kinetic,
  energy_elastic,
  energy_brake,
  energy_unaccounted,
  winding_temperature,
  rotor_temperature,
  housing_temperature,
  inverter_loss,
  inverter_efficiency,
  junction_temperature,
  case_temperature,
  speed_error_rms,
  shaft_torque_min,
  shaft_torque_max,
  load_speed_min,
  load_speed_max,
  simulated,
  wall,
  realtime_factor
};

/// Name, unit and meaning of a metric.
struct MetricInfo {
  const char* name;
  const char* unit;
  const char* meaning;
};

inline constexpr std::size_t metric_count = 52;

/// Every metric, in the order of `Metric`. The names are those of summaries and of a scenario's `[expect]`.
inline constexpr std::array<MetricInfo, metric_count> metric_catalogue{{
    {"torque_ripple_pp_nm", "N·m", "largest minus smallest torque error in the window"},
    {"torque_ripple_rms_nm", "N·m", "RMS of the torque error about its mean in the window"},
    {"torque_bias_nm", "N·m", "mean torque error, torque minus reference, in the window"},
    {"torque_error_rms_nm", "N·m", "RMS of torque minus reference in the window"},
    {"torque_error_max_nm", "N·m", "largest magnitude of torque minus reference in the window"},
    {"torque_deviation_nm", "N·m",
     "sampled runs: largest distance in the window between the mean torque over 20 ms and the attainable "
     "command, which is the commanded torque within the published available one"},
    {"torque_silent_ms", "ms",
     "longest time in the window for which that distance was above metrics.torque_tolerance_nm and 5 % of "
     "the attainable command while the gates were on without a fault"},
    {"torque_motoring_nm", "N·m",
     "published available torque for motoring, mean in the window up to a fault"},
    {"torque_regenerating_nm", "N·m",
     "published available torque for regenerating, mean in the window up to a fault"},
    {"response_time_ms", "ms", "from the step until the torque has covered 95 % of it"},
    {"flux_mean_wb", "Wb", "mean stator flux magnitude in the window"},
    {"flux_min_wb", "Wb", "smallest stator flux magnitude in the window"},
    {"flux_max_wb", "Wb", "largest stator flux magnitude in the window"},
    {"switching_frequency_hz", "Hz",
     "turn-ons of an upper switch per second in the window, mean of the legs"},
    {"torque_pulse_frequency_hz", "Hz",
     "pulses of the torque comparator, which begin where its output becomes +1 or -1, per second in the "
     "window"},
    {"dwell_limited", "1", "switching events of the whole run that had to wait for the minimum dwell"},
    {"short_pulses", "1",
     "pulses of a leg, high or low, of the whole run that were commanded for less than "
     "plant.inverter.minimum_pulse_us, where there is one"},
    {"peak_current_a", "A", "largest phase current of the whole run"},
    {"current_thd_percent", "%",
     "current harmonics to fundamental in the window; none unless torque reference and fundamental stand "
     "still"},
    {"energy_from_link_j", "J", "drawn from the DC link in the window"},
    {"energy_to_link_j", "J", "fed back into the DC link in the window"},
    {"energy_shaft_j", "J", "net work of the air-gap torque on the shaft in the window"},
    {"energy_copper_j", "J",
     "lost in the windings, and in switches and diodes that have drops, in the window"},
    {"energy_iron_j", "J", "lost in the iron, where plant.iron_loss has some, in the window"},
    {"energy_field_j", "J", "change of the magnetic field's energy in the window"},
    {"energy_inverter_j", "J",
     "drawn from the DC link in the window, where plant.inverter.losses has curves, for what switches and "
     "diodes lose beyond their drops, which are in energy_copper_j"},
    {"energy_source_j", "J", "delivered by the source of a link with capacitance in the window"},
    {"energy_source_loss_j", "J",
     "lost in the resistances of that source and of its pre-charge in the window"},
    {"energy_chopper_j", "J", "lost in the brake chopper of that link in the window"},
    {"energy_stored_j", "J",
     "change of the energy in the capacitor of that link and the inductance of its source in the window"},
    {"energy_friction_j", "J", "lost in the motor's viscous friction before a driveline in the window"},
    {"energy_damping_j", "J", "lost in the damping of that driveline's shaft in the window"},
    {"energy_load_j", "J", "work on load torque and road load behind that driveline in the window"},
    {"energy_kinetic_j", "J",
     "change of the kinetic energy of motor and load, one before and one behind that driveline, in the "
     "window"},
    {"energy_elastic_j", "J", "change of the energy in the twist of that driveline's shaft in the window"},
    {"energy_brake_j", "J",
     "turned into heat by the friction brake of a vehicle at one motor in the whole run, where it has acted"},
    {"energy_unaccounted", "1",
     "of the whole run: energy from the link that is neither work nor loss nor field, energy of a link with "
     "capacitance that is neither lost nor stored nor passed on, and work before a driveline that is neither "
     "lost nor stored nor done on the load, as a share of what has flowed"},
    {"winding_temperature_c", "°C",
     "highest temperature of the stator winding in the window, where plant.thermal has a network"},
    {"rotor_temperature_c", "°C", "the same of the rotor"},
    {"housing_temperature_c", "°C", "the same of the housing"},
    {"inverter_loss_w", "W",
     "mean loss of all switches and diodes in the window, where plant.inverter.losses has curves"},
    {"inverter_efficiency", "1",
     "of the energy that has crossed the inverter in the window, net, the share that it has not lost"},
    {"junction_temperature_c", "°C",
     "highest temperature of a junction in the window, where plant.inverter.losses has curves"},
    {"case_temperature_c", "°C", "the same of the case of switches and diodes"},
    {"speed_error_rms_rad_s", "rad/s", "RMS of speed minus its reference in the window, if there is one"},
    {"shaft_torque_min_nm", "N·m", "smallest torque of a driveline's shaft in the window"},
    {"shaft_torque_max_nm", "N·m", "largest torque of a driveline's shaft in the window"},
    {"load_speed_min_rad_s", "rad/s",
     "smallest speed of the load behind a driveline, referred to the motor's shaft, in the window"},
    {"load_speed_max_rad_s", "rad/s",
     "largest speed of the load behind a driveline, referred to the motor's shaft, in the window"},
    {"simulated_s", "s", "length of the run in the drive's time"},
    {"wall_s", "s", "length of the run in wall time"},
    {"realtime_factor", "1", "simulated time per wall time"},
}};

/// The metric of that name, if there is one.
[[nodiscard]] constexpr std::optional<Metric> find_metric(std::string_view name) noexcept {
  for (std::size_t k = 0; k < metric_count; ++k) {
    if (name == metric_catalogue[k].name) return static_cast<Metric>(k);
  }
  return std::nullopt;
}

[[nodiscard]] constexpr const MetricInfo& info(Metric m) noexcept {
  return metric_catalogue[static_cast<std::size_t>(m)];
}

/// A value for every metric, in catalogue order; NaN where the run gave none.
class MetricList {
 public:
  constexpr MetricList() noexcept { values_.fill(std::numeric_limits<double>::quiet_NaN()); }

  [[nodiscard]] constexpr double& operator[](Metric m) noexcept {
    return values_[static_cast<std::size_t>(m)];
  }
  [[nodiscard]] constexpr double operator[](Metric m) const noexcept {
    return values_[static_cast<std::size_t>(m)];
  }

  /// Values in the order of `metric_catalogue`.
  [[nodiscard]] constexpr const std::array<double, metric_count>& values() const noexcept { return values_; }

 private:
  std::array<double, metric_count> values_{};
};

}  // namespace sextant
