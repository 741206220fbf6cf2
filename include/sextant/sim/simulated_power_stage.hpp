#pragma once

#include <concepts>
#include <cstdint>
#include <memory>
#include <stdexcept>

#include "sextant/plant/appended_pair.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/dc_link.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/energy_meter.hpp"
#include "sextant/plant/erk_integrator.hpp"
#include "sextant/plant/exact_integrator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"
#include "sextant/plant/plant_heating.hpp"
#include "sextant/plant/thermal_parameters.hpp"
#include "sextant/sim/mechanical_load.hpp"
#include "sextant/sim/simulated_drive_io.hpp"

namespace sextant {

/// Which integrator moves the plant.
enum class IntegratorKind : std::uint8_t {
  cvode,  ///< SUNDIALS CVODE: error-controlled, the default
  fixed,  ///< Runge-Kutta of order 4 with a fixed step: bounded time
  exact,  ///< exact discretisation at frozen speed: bounded time, no error where the speed is constant
  erk     ///< SUNDIALS ARKODE, an explicit Runge-Kutta pair: error-controlled, no history
};

/// What a simulated power stage is made of.
struct SimulatedPowerStageParameters {
  DrivePlantParameters<double> plant{};
  DcLinkParameters<double> link{};      ///< between a source of `io.u_dc` and the inverter; stiff by default
  ThermalParameters<double> thermal{};  ///< of the machine; none by default
  SimulatedDriveIoParameters io{};
  IntegratorKind integrator{IntegratorKind::cvode};
  CvodeParameters cvode{};
  FixedStepParameters fixed{};  ///< also moves the plant of integrator `exact` while legs are off
  ExactParameters exact{};
  ErrorControl erk{};

  [[nodiscard]] const char* validate() const noexcept {
    if (const char* problem = plant.validate()) return problem;
    if (const char* problem = io.validate()) return problem;
    if (const char* problem = link.validate()) return problem;
    if (const char* problem = thermal.validate()) return problem;
    if (link.has_chopper() && !(link.chopper_off > io.u_dc))
      return "the brake chopper must turn off above the voltage of the source, or it loads the source";
    if (const char* problem = cvode.validate()) return problem;
    if (const char* problem = fixed.validate()) return problem;
    if (const char* problem = exact.validate()) return problem;
    if (integrator == IntegratorKind::exact && plant.saturation.acts())
      return "the exact integrator moves machines without saturation only";
    if (integrator == IntegratorKind::exact && plant.iron_loss.acts())
      return "the exact integrator moves machines without iron loss only";
    return erk.validate();
  }
};

/// A plant whose energies are metered and integrated with it.
using MeteredPlant = DrivePlant<double, EnergyMeter<double>>;

/// The same behind a DC link whose voltage is a state.
using LinkedMeteredPlant = DrivePlant<double, AppendedPair<DcLink<double>, EnergyMeter<double>>>;

/// Inverter, machine, shaft and their integrator behind one `DriveIo`, in place of the hardware. Whether the
/// link is stiff (`SimulatedPowerStageParameters::link`) decides the type of the plant.
template <class PlantType, class Log>
class BasicSimulatedPowerStage {
 public:
  using Plant = PlantType;
  using Io = SimulatedDriveIo<Plant, Log>;
  using Parameters = SimulatedPowerStageParameters;

  /// Throws std::runtime_error when the integrator cannot be set up, the load is malformed, the link is not
  /// that of this power stage, or its machine is to be heated without a meter.
  BasicSimulatedPowerStage(const Parameters& parameters, const MechanicalLoad::Parameters& load)
      : load_{load},
        plant_{plant_of(parameters), make_appended<typename Plant::AppendedType>(parameters)},
        heating_{make_heating(parameters, plant_)},
        integrator_{make_integrator(parameters)},
        io_{parameters.io, plant_, *integrator_, load_, heating_.get()} {}

  [[nodiscard]] Io& io() noexcept { return io_; }

  /// The integrator that the parameters name. Throws std::runtime_error when it cannot be set up.
  static std::unique_ptr<PlantIntegrator<Plant>> make_integrator(const Parameters& parameters) {
    switch (parameters.integrator) {
      case IntegratorKind::fixed:
        return std::make_unique<FixedStepIntegrator<Plant>>(parameters.fixed);
      case IntegratorKind::exact:
        return std::make_unique<ExactIntegrator<Plant>>(parameters.exact, parameters.fixed);
      case IntegratorKind::erk:
        return std::make_unique<ErkIntegrator<Plant>>(parameters.erk);
      case IntegratorKind::cvode:
        break;
    }
    return std::make_unique<CvodeIntegrator<Plant>>(parameters.cvode);
  }

 private:
  static DrivePlantParameters<double> plant_of(const Parameters& parameters) {
    if (parameters.link.acts() != Plant::feeds_back)
      throw std::runtime_error(parameters.link.acts()
                                   ? "this power stage has a stiff DC link: a capacitance needs a linked one"
                                   : "this power stage has a DC link whose capacitance must be above zero");
    return parameters.plant;
  }

  /// Null where there is none.
  static std::unique_ptr<PlantHeating<Plant>> make_heating(const Parameters& parameters, Plant& plant) {
    if (!parameters.thermal.acts()) return {};
    if constexpr (has_resistances<typename Plant::AppendedType>)
      return std::make_unique<PlantHeating<Plant>>(parameters.plant, parameters.thermal, plant);
    else
      throw std::runtime_error("this power stage has no energy meter: a thermal network needs a metered one");
  }

  template <class Appended>
  static Appended make_appended(const Parameters& p) {
    const InductionMachineParameters<double>& m = p.plant.machine;
    if constexpr (std::same_as<Appended, NoAppendedSystem<double>>)
      return {};
    else if constexpr (std::same_as<Appended, EnergyMeter<double>>)
      return {m.r_s + p.plant.drops.slope_resistance, m.r_r};
    else if constexpr (std::same_as<Appended, DcLink<double>>)
      return {p.link, m.sigma_l_s(), p.io.u_dc};
    else
      return {make_appended<decltype(Appended::first)>(p), make_appended<decltype(Appended::second)>(p)};
  }

  MechanicalLoad load_;
  Plant plant_;
  std::unique_ptr<PlantHeating<Plant>> heating_;
  std::unique_ptr<PlantIntegrator<Plant>> integrator_;
  Io io_;
};

/// The power stage of a live drive, with a stiff link.
using SimulatedPowerStage = BasicSimulatedPowerStage<DrivePlant<double>, NoSegmentLog<DrivePlant<double>>>;

/// The same with a DC link whose voltage is a state.
using LinkedPowerStage = BasicSimulatedPowerStage<DrivePlant<double, DcLink<double>>,
                                                  NoSegmentLog<DrivePlant<double, DcLink<double>>>>;

/// The power stage of a scenario: with energy meter and a log of every gate segment.
using MeteredPowerStage = BasicSimulatedPowerStage<MeteredPlant, SegmentLog<MeteredPlant>>;

/// The same with a DC link whose voltage is a state.
using LinkedMeteredPowerStage = BasicSimulatedPowerStage<LinkedMeteredPlant, SegmentLog<LinkedMeteredPlant>>;

}  // namespace sextant
