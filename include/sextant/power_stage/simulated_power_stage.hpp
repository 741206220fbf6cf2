#pragma once

#include <concepts>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <type_traits>

#include "sextant/plant/appended_pair.hpp"
#include "sextant/plant/cvode_integrator.hpp"
#include "sextant/plant/dc_link.hpp"
#include "sextant/plant/drive_plant.hpp"
#include "sextant/plant/driveline.hpp"
#include "sextant/plant/energy_meter.hpp"
#include "sextant/plant/erk_integrator.hpp"
#include "sextant/plant/exact_integrator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"
#include "sextant/plant/inverter_loss_parameters.hpp"
#include "sextant/plant/inverter_losses.hpp"
#include "sextant/plant/plant_heating.hpp"
#include "sextant/plant/thermal_parameters.hpp"
#include "sextant/power_stage/mechanical_load.hpp"
#include "sextant/power_stage/simulated_drive_io.hpp"

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
  InverterLossParameters losses{};      ///< of the inverter; none by default
  DrivelineParameters<double> driveline{};  ///< between motor and load; none by default
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
    if (const char* problem = losses.validate()) return problem;
    if (const char* problem = driveline.validate()) return problem;
    if (losses.acts() && io.law == InverterLaw::averaged)
      return "losses of the inverter are those of its edges: its law must be switched";
    if (link.has_chopper() && !(link.chopper_off > io.u_dc))
      return "the brake chopper must turn off above the voltage of the source, or it loads the source";
    if (const char* problem = cvode.validate()) return problem;
    if (const char* problem = fixed.validate()) return problem;
    if (const char* problem = exact.validate()) return problem;
    if (integrator == IntegratorKind::exact && plant.saturates())
      return "the exact integrator moves machines without saturation only";
    if (integrator == IntegratorKind::exact && plant.iron_loss.acts())
      return "the exact integrator moves machines without iron loss only";
    return erk.validate();
  }
};

/// A link whose voltage is a state, and a load behind a driveline.
using LinkAndDriveline = AppendedPair<DcLink<double>, Driveline<double>>;

/// use(kind) with the `std::type_identity` of what link and driveline of the parameters append to the plant.
template <class Use>
auto with_appended(const SimulatedPowerStageParameters& parameters, const Use& use) {
  const bool linked = parameters.link.acts();
  if (parameters.driveline.acts())
    return linked ? use(std::type_identity<LinkAndDriveline>{})
                  : use(std::type_identity<Driveline<double>>{});
  return linked ? use(std::type_identity<DcLink<double>>{})
                : use(std::type_identity<NoAppendedSystem<double>>{});
}

/// Inverter, machine, shaft and their integrator behind one `DriveIo`, in place of the hardware. Whether the
/// link is stiff and the load on the motor's shaft (`SimulatedPowerStageParameters`: link, driveline) decides
/// the type of the plant. Behind a driveline the road load acts on the load.
template <class PlantType, class Log>
class BasicSimulatedPowerStage {
 public:
  using Plant = PlantType;
  using Appended = typename Plant::AppendedType;
  using Io = SimulatedDriveIo<Plant, Log>;
  using Parameters = SimulatedPowerStageParameters;

  /// Throws std::runtime_error when the integrator cannot be set up, the load is malformed, link or driveline
  /// are not those of this power stage, or its machine is to be heated, or its inverter to have losses,
  /// without a meter.
  BasicSimulatedPowerStage(const Parameters& parameters, const MechanicalLoad::Parameters& load)
      : load_{load},
        plant_{plant_of(parameters), make_appended<Appended>(parameters)},
        heating_{make_heating(parameters, plant_)},
        losses_{make_losses(parameters)},
        integrator_{make_integrator(parameters)},
        io_{parameters.io, plant_, *integrator_, load_, heating_.get(), losses_.get()} {}

  [[nodiscard]] Io& io() noexcept { return io_; }

  /// The integrator that the parameters name. Throws std::runtime_error when it cannot be set up.
  static std::unique_ptr<PlantIntegrator<Plant>> make_integrator(const Parameters& parameters);

 private:
  static DrivePlantParameters<double> plant_of(const Parameters& parameters) {
    if (parameters.link.acts() != has_part<DcLink<double>, Appended>)
      throw std::runtime_error(parameters.link.acts()
                                   ? "this power stage has a stiff DC link: a capacitance needs a linked one"
                                   : "this power stage has a DC link whose capacitance must be above zero");
    constexpr bool has_driveline = has_part<Driveline<double>, Appended>;
    if (parameters.driveline.acts() != has_driveline)
      throw std::runtime_error(
          parameters.driveline.acts()
              ? "this power stage has its load on the motor's shaft: a driveline needs another one"
              : "this power stage has a driveline whose inertia must be above zero");
    DrivePlantParameters<double> plant = parameters.plant;
    if (has_driveline) plant.road_load = {};
    return plant;
  }

  /// Null where there is none.
  static std::unique_ptr<PlantHeating<Plant>> make_heating(const Parameters& parameters, Plant& plant) {
    if (!parameters.thermal.acts()) return {};
    if constexpr (has_part<EnergyMeter<double>, Appended>)
      return std::make_unique<PlantHeating<Plant>>(parameters.plant, parameters.thermal, plant);
    else
      throw std::runtime_error("this power stage has no energy meter: a thermal network needs a metered one");
  }

  /// Null where there are none.
  static std::unique_ptr<InverterLosses> make_losses(const Parameters& parameters) {
    if (!parameters.losses.acts()) return {};
    if constexpr (has_part<EnergyMeter<double>, Appended> && Log::wants_corners)
      return std::make_unique<InverterLosses>(parameters.losses, parameters.plant.drops);
    else
      throw std::runtime_error(
          "this power stage has no energy meter: losses of the inverter need a metered one");
  }

  template <class System>
  static System make_appended(const Parameters& p) {
    const InductionMachineParameters<double>& m = p.plant.machine;
    if constexpr (std::same_as<System, NoAppendedSystem<double>> || std::same_as<System, EnergyMeter<double>>)
      return {};
    else if constexpr (std::same_as<System, DcLink<double>>)
      return {p.link, m.sigma_l_s(), p.link.initial_voltage.value_or(p.io.u_dc), p.io.u_dc};
    else if constexpr (std::same_as<System, Driveline<double>>)
      return {p.driveline, m.inertia, p.plant.viscous_friction, p.plant.road_load};
    else
      return {make_appended<decltype(System::first)>(p), make_appended<decltype(System::second)>(p)};
  }

  MechanicalLoad load_;
  Plant plant_;
  std::unique_ptr<PlantHeating<Plant>> heating_;
  std::unique_ptr<InverterLosses> losses_;
  std::unique_ptr<PlantIntegrator<Plant>> integrator_;
  Io io_;
};

template <class PlantType, class Log>
std::unique_ptr<PlantIntegrator<PlantType>> BasicSimulatedPowerStage<PlantType, Log>::make_integrator(
    const Parameters& parameters) {
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

/// The power stage of a live drive, of a plant with that appended system.
template <class Appended>
using PowerStageOf =
    BasicSimulatedPowerStage<DrivePlant<double, Appended>, NoSegmentLog<DrivePlant<double, Appended>>>;

/// With a stiff link and the load on the motor's shaft.
using SimulatedPowerStage = PowerStageOf<NoAppendedSystem<double>>;

/// The same with a DC link whose voltage is a state.
using LinkedPowerStage = PowerStageOf<DcLink<double>>;

/// A plant whose energies are metered and integrated with it, beside what else is appended.
template <class Appended>
struct Metered {
  using Plant = DrivePlant<double, AppendedPair<Appended, EnergyMeter<double>>>;
};
template <>
struct Metered<NoAppendedSystem<double>> {
  using Plant = DrivePlant<double, EnergyMeter<double>>;
};

using MeteredPlant = Metered<NoAppendedSystem<double>>::Plant;

/// The power stage of a scenario, of a plant with that appended system: with energy meter and a log of every
/// gate segment.
template <class Appended>
using MeteredPowerStageOf = BasicSimulatedPowerStage<typename Metered<Appended>::Plant,
                                                     SegmentLog<typename Metered<Appended>::Plant>>;

/// With a stiff link and the load on the motor's shaft.
using MeteredPowerStage = MeteredPowerStageOf<NoAppendedSystem<double>>;

/// The same with a DC link whose voltage is a state.
using LinkedMeteredPowerStage = MeteredPowerStageOf<DcLink<double>>;

// Compiled once, in src/power_stage/power_stages.cpp.
extern template class BasicSimulatedPowerStage<PowerStageOf<NoAppendedSystem<double>>::Plant,
                                               NoSegmentLog<PowerStageOf<NoAppendedSystem<double>>::Plant>>;
extern template class SimulatedDriveIo<PowerStageOf<NoAppendedSystem<double>>::Plant,
                                       NoSegmentLog<PowerStageOf<NoAppendedSystem<double>>::Plant>>;
extern template class BasicSimulatedPowerStage<Metered<NoAppendedSystem<double>>::Plant,
                                               SegmentLog<Metered<NoAppendedSystem<double>>::Plant>>;
extern template class SimulatedDriveIo<Metered<NoAppendedSystem<double>>::Plant,
                                       SegmentLog<Metered<NoAppendedSystem<double>>::Plant>>;
extern template class BasicSimulatedPowerStage<PowerStageOf<DcLink<double>>::Plant,
                                               NoSegmentLog<PowerStageOf<DcLink<double>>::Plant>>;
extern template class SimulatedDriveIo<PowerStageOf<DcLink<double>>::Plant,
                                       NoSegmentLog<PowerStageOf<DcLink<double>>::Plant>>;
extern template class BasicSimulatedPowerStage<Metered<DcLink<double>>::Plant,
                                               SegmentLog<Metered<DcLink<double>>::Plant>>;
extern template class SimulatedDriveIo<Metered<DcLink<double>>::Plant,
                                       SegmentLog<Metered<DcLink<double>>::Plant>>;
extern template class BasicSimulatedPowerStage<PowerStageOf<Driveline<double>>::Plant,
                                               NoSegmentLog<PowerStageOf<Driveline<double>>::Plant>>;
extern template class SimulatedDriveIo<PowerStageOf<Driveline<double>>::Plant,
                                       NoSegmentLog<PowerStageOf<Driveline<double>>::Plant>>;
extern template class BasicSimulatedPowerStage<Metered<Driveline<double>>::Plant,
                                               SegmentLog<Metered<Driveline<double>>::Plant>>;
extern template class SimulatedDriveIo<Metered<Driveline<double>>::Plant,
                                       SegmentLog<Metered<Driveline<double>>::Plant>>;
extern template class BasicSimulatedPowerStage<PowerStageOf<LinkAndDriveline>::Plant,
                                               NoSegmentLog<PowerStageOf<LinkAndDriveline>::Plant>>;
extern template class SimulatedDriveIo<PowerStageOf<LinkAndDriveline>::Plant,
                                       NoSegmentLog<PowerStageOf<LinkAndDriveline>::Plant>>;
extern template class BasicSimulatedPowerStage<Metered<LinkAndDriveline>::Plant,
                                               SegmentLog<Metered<LinkAndDriveline>::Plant>>;
extern template class SimulatedDriveIo<Metered<LinkAndDriveline>::Plant,
                                       SegmentLog<Metered<LinkAndDriveline>::Plant>>;

}  // namespace sextant
