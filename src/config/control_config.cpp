#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "drive_sections.hpp"
#include "sextant/drive/resolved.hpp"

namespace sextant {
namespace {

/// The flux of the link at the frequency of the machine's data sheet; no number without that. [Wb]
double default_flux(const DriveConfig& c) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  return flux_at_voltage_limit(c.plant.io.u_dc, c.machine.reactance_frequency_hz.value_or(none));
}

/// Every value of the drive that follows from others.
void resolve(DriveConfig& c) {
  const ResolvedDrive<> r = resolved(c.setup);
  c.control = r.control;
  c.drive = r.drive;
  c.magnetise_timeout_ms =
      c.setup.magnetise_timeout_ms.value_or(default_magnetise_timeout_ms(c.control.machine));
}

}  // namespace

/// What every control method shares, and the table of each.
void describe_control(Section s, DriveConfig& c) {
  s.section("machine_estimate").section("saturation").check_basis("", [&c] {
    return sentence(c.setup.basis.saturation.validate());
  });
  describe_choice(s, "controller", c.controller, {}, "control method", c.methods);
  double& flux = c.setup.basis.flux_reference;
  s.defaulted_by(
      "flux_reference_wb", flux, [&c, &flux] { flux = default_flux(c); },
      {"Wb", 0.01, 10,
       "stator flux linkage that the controller holds where the voltage suffices; more takes less slip and "
       "more current without torque",
       Changes::when_ready},
      "the machine names no reactance_frequency_hz, or no usable flux follows from it and plant.u_dc_v");
  s.derive([&c] { resolve(c); });
  s.choice(
      "flux_estimator", c.setup.flux_estimator,
      {{"hybrid", FluxEstimatorKind::hybrid},
       {"voltage_model", FluxEstimatorKind::voltage_model},
       {"compensated_voltage_model", FluxEstimatorKind::compensated_voltage_model},
       {"current_model", FluxEstimatorKind::current_model},
       {"observer", FluxEstimatorKind::observer},
       {"sensorless_observer", FluxEstimatorKind::sensorless_observer}},
      "voltage model at speed and current model near standstill; the paper's open integrator; that with a "
      "low-pass filter; rotor flux from current and speed; full-order observer with measured, or with "
      "estimated speed",
      Changes::when_ready);
  s.flag("adapts_parameters", c.setup.adapts_parameters,
         "with the flux estimators hybrid, current_model and observer: R_s, R_r and L_m are identified while "
         "the machine is magnetised, and follow it while torque is made (hybrid); false: those of "
         "[control.machine_estimate] hold",
         Changes::when_ready);
  describe(s, c.setup.winding);
  s.section("r_s_per_k").check([&c]() -> std::string {
    const bool is_known =
        std::isfinite(c.drive.protection.winding.nominal_current) || c.plant.io.measures_winding_temperature;
    if (!c.setup.winding.varies() || is_known) return {};
    return "R_s cannot follow a temperature that is not known: set protection.winding.nominal_current_a or "
           "plant.measures_winding_temperature, or r_s_per_k to 0";
  });
  s.check([&c]() -> std::string {
    if (zero_torque_speed(c.control.machine, c.control.flux_reference, c.plant.io.u_dc) > 0.0) return {};
    return "the link cannot feed flux_reference_wb even at standstill: lower it or raise plant.u_dc_v";
  });
  for (auto& method : c.methods) {
    Section of_method = s.section(method->name());
    method->describe_table(of_method, c.control);
    of_method.change_at_least(Changes::when_ready);
    of_method.optional([&c, name = method->name()] { return c.controller == name; });
  }
  Section estimate = s.section_or_file("machine_estimate");
  describe_changes(estimate, c.machine_estimate, c.machine, "that of [machine]",
                   [&c] { return c.machine_circuit(); });
  Section saturation = estimate.section("saturation");
  describe(saturation, c.setup.basis.saturation);
  estimate.change_at_least(Changes::when_ready);
}

}  // namespace sextant
