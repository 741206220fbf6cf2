// Drives whose every limit follows from machine, link and period, over machines of 0.25 to 200 kW.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "run/machine_run.hpp"

namespace sextant {
namespace {

// With the switching table one vector for one period may move the torque by a third of its limit: for 50 us
// on the traction machine it moves it by more.
int period_us_of(const TestMachine& machine, const std::string& controller, int period_us = 50) {
  if (controller != "dtc") return period_us;
  return machine.parameters.sigma_l_s() < 1e-4 ? 10 : std::min(period_us, 125);
}

// One vector for one period moves the current of some of these machines by more than the limit of
// magnetising.
TEST(MachinesRun, MethodsOfOneVectorAPeriodMagnetiseEveryMachine) {
  for (const TestMachine& machine : test_machines) {
    for (const char* controller : {"dtc", "predictive"}) {
      for (const double sign : {-1.0, 1.0}) {
        SCOPED_TRACE(testing::Message() << machine.name << ", " << controller << ", " << sign);
        const double tau_r = machine.parameters.tau_r();
        const MilResult result = run(machine, {.controller = controller,
                                               .period_us = period_us_of(machine, controller, 250),
                                               .omega_m = sign * 0.1 * machine.base_speed(),
                                               .end_s = std::max(0.3, 2.5 * tau_r)});
        EXPECT_FALSE(result.faults.any());
        EXPECT_EQ(result.final_state, DriveState::torque);
        EXPECT_GT(result.metrics[Metric::flux_mean], 0.9 * machine.psi);
      }
    }
  }
}

// At 25 control periods a turn of the flux and less the EMF turns within a period.
TEST(MachinesRun, ModulatedMethodsMagnetiseAtFewPeriodsATurn) {
  for (const TestMachine& machine : test_machines) {
    for (const char* controller : {"foc", "pwm_dtc", "deadbeat", "feedback_linearisation"}) {
      for (const double speed : {-0.8, 0.75}) {
        SCOPED_TRACE(testing::Message() << machine.name << ", " << controller << ", " << speed);
        const MilResult result = run(machine, {.controller = controller,
                                               .period_us = 250,
                                               .omega_m = speed * machine.base_speed(),
                                               .end_s = std::max(0.3, 2.5 * machine.parameters.tau_r())});
        EXPECT_FALSE(result.faults.any());
        EXPECT_TRUE(makes_torque(result.final_state));
      }
    }
  }
}

// Shorter vectors alone would not feed the EMF. The switching table, of whole vectors, needs a shorter
// period.
TEST(MachinesRun, MethodsOfOneVectorAPeriodMakeTorqueOnMachinesThatTurnFast) {
  for (const TestMachine& machine : test_machines) {
    for (const char* controller : {"dtc", "predictive"}) {
      for (const double speed : {-1.2, -0.5, 0.0, 0.8}) {
        SCOPED_TRACE(testing::Message() << machine.name << ", " << controller << ", " << speed);
        const double begin_s = std::max(0.3, 3.0 * machine.parameters.tau_r());
        const double torque = 0.2 * drive_limits(machine.parameters, machine.psi, machine.u_dc).torque;
        std::ostringstream points;
        points << "[[0, 0], [" << begin_s << ", " << torque << "]]";
        const MilResult result = run(machine, {.controller = controller,
                                               .period_us = period_us_of(machine, controller, 250),
                                               .omega_m = speed * machine.base_speed(),
                                               .end_s = begin_s + 0.4,
                                               .torque = points.str()});
        EXPECT_FALSE(result.faults.any());
        EXPECT_TRUE(makes_torque(result.final_state));
        EXPECT_NEAR(result.metrics[Metric::torque_bias], 0.0, 0.1 * torque);
      }
    }
  }
}

// Stator voltage of the steady state at a flux and a regenerated torque, by R_s i_s + j omega_s psi_s. [V]
double regenerating_voltage(const TestMachine& machine, double psi, double torque, double omega_m) {
  const InductionMachineParameters<>& m = machine.parameters;
  const SteadyState<> x = steady_state(m, psi, -relative_slip(torque, breakdown_torque(m, psi)));
  const double omega_s = m.pole_pairs * omega_m + x.omega_slip;
  return std::hypot(m.r_s * x.i_d, m.r_s * x.i_q + omega_s * psi);
}

// Its stator flux turns slower than the rotor: more flux than the link turns with the rotor. The drop in R_s,
// which adds to the link, is left in reserve.
TEST(MachinesRun, AGeneratorOfLargeSlipHasTheFluxOfItsTorqueAtTwiceBaseSpeed) {
  const TestMachine& machine = test_machines[0];
  const double torque = 0.9 * drive_limits(machine.parameters, machine.psi, machine.u_dc).torque;
  const double omega_m = 2 * machine.base_speed();
  const double turned = 2 / std::numbers::pi * machine.u_dc / (machine.parameters.pole_pairs * omega_m);
  for (const char* controller : {"dtc", "predictive", "foc"}) {
    for (const double sign : {1.0, -1.0}) {
      SCOPED_TRACE(testing::Message() << controller << ", " << sign);
      const std::string points = "[[0, 0], [0.3, " + std::to_string(-sign * torque) + "]]";
      const MilResult result = run(machine, {.controller = controller,
                                             .period_us = 125,
                                             .omega_m = sign * omega_m,
                                             .end_s = 0.6,
                                             .torque = points});
      EXPECT_EQ(result.final_state, DriveState::torque);
      EXPECT_NEAR(result.metrics[Metric::torque_bias], 0.0, 0.03 * torque);
      const double psi = result.metrics[Metric::flux_mean];
      EXPECT_GT(psi, 1.1 * turned);
      const double largest = machine.u_dc / std::numbers::sqrt3;
      EXPECT_GT(regenerating_voltage(machine, psi, torque, omega_m), 0.95 * largest);
    }
  }
}

// From 2 % of base speed on the first magnetising shows an encoder or cables the wrong way round. The checks
// of the currents, whose model turns the other way, may be first.
TEST(MachinesRun, AShaftThatTurnsAgainstItsReadingIsASpeedFault) {
  int n = 0;
  for (const TestMachine& machine : test_machines) {
    for (const char* fault : {"encoder_reversed", "cables_swapped"}) {
      for (const double share : {-0.3, -0.02, 0.02, 0.3}) {
        const char* controller = n++ % 2 == 0 ? "foc" : "dtc";
        SCOPED_TRACE(testing::Message()
                     << machine.name << ", " << fault << ", " << share << ", " << controller);
        const MilResult result = run(machine, {.controller = controller,
                                               .period_us = period_us_of(machine, controller),
                                               .omega_m = share * machine.base_speed(),
                                               .end_s = std::max(0.3, 1.5 * machine.parameters.tau_r()),
                                               .fault = fault});
        ASSERT_TRUE(result.faults.any());
        const bool of_currents =
            result.first_fault == Fault::current_sensor || result.first_fault == Fault::open_phase;
        EXPECT_TRUE(result.first_fault == Fault::speed_sensor || of_currents)
            << to_string(result.first_fault);
      }
    }
  }
}

TEST(MachinesRun, AShaftThatTurnsAsItIsReadIsNoFault) {
  int n = 0;
  for (const TestMachine& machine : test_machines) {
    for (const double share : {-0.3, -0.02, 0.005, 0.05, 0.5}) {
      // The second: through standstill while the flux is built up.
      for (const bool passes : {false, true}) {
        const char* controller = n++ % 2 == 0 ? "dtc" : "foc";
        SCOPED_TRACE(testing::Message()
                     << machine.name << ", " << share << ", " << passes << ", " << controller);
        const double end_s = std::max(0.3, 1.5 * machine.parameters.tau_r());
        const double omega = share * machine.base_speed();
        const MilResult result = run(machine, {.controller = controller,
                                               .period_us = period_us_of(machine, controller),
                                               .omega_m = omega,
                                               .slope = passes ? -2.0 * omega / end_s : 0.0,
                                               .end_s = end_s});
        EXPECT_FALSE(result.faults.any());
      }
    }
  }
}

// R_s, R_r and L_m of the machine by those of the drive.
struct Factors {
  double r_s;
  double r_r;
  double l_m;
};

MilResult run_otherwise(const TestMachine& machine, const Factors& factors, const MachineRun& r) {
  ScenarioConfig config = machine_config(machine, r);
  InductionMachineParameters<>& plant = config.drive.plant.plant.machine;
  plant.r_s *= factors.r_s;
  plant.r_r *= factors.r_r;
  plant.l_m *= factors.l_m;
  return run(config);
}

// An encoder shows the speed late by half of its window: while the shaft gathers speed the flux of the
// current model falls back, the further the slower the rotor's currents decay. Torque starts without a swing.
TEST(MachinesRun, ModulatedMethodsStartOnAShaftThatGathersSpeedByAnEncoder) {
  for (const TestMachine& machine : test_machines) {
    for (const char* controller : {"foc", "deadbeat", "pwm_dtc"}) {
      for (const double sign : {-1.0, 1.0}) {
        SCOPED_TRACE(testing::Message() << machine.name << ", " << controller << ", " << sign);
        const double end_s = std::max(0.4, 1.2 * machine.parameters.tau_r());
        ScenarioConfig config = machine_config(machine, {.controller = controller,
                                                         .period_us = 100,
                                                         .slope = sign * 0.9 * machine.base_speed() / end_s,
                                                         .end_s = end_s});
        config.drive.plant.io.sensors.encoder = {
            .lines = 1024, .speed = EncoderSpeed::period, .window_periods = 20};
        config.scenario.metrics.from_ns = std::llround(0.4e9 * end_s);
        const MilResult result = run(config);
        EXPECT_FALSE(result.faults.any()) << to_string(result.first_fault);
        EXPECT_TRUE(makes_torque(result.final_state));
        const double limit = drive_limits(machine.parameters, machine.psi, machine.u_dc).torque;
        EXPECT_LT(result.metrics[Metric::torque_error_max], 0.09 * limit);
      }
    }
  }
}

// On the way into weakened flux, without torque, the rotor flux of a slower machine is a multiple of what the
// current tells a faster model.
TEST(MachinesRun, AMachineWhoseFluxFallsMoreSlowlyThanItsModelShowsNoFault) {
  for (const TestMachine& machine : test_machines) {
    for (const double sign : {-1.0, 1.0}) {
      SCOPED_TRACE(testing::Message() << machine.name << ", " << sign);
      const double start_s = 1.5 * machine.parameters.tau_r();
      const double end_s = start_s + 2.5 * machine.parameters.tau_r();
      MachineRun r{.period_us = 25, .omega_m = 0.0, .slope = 1.0, .end_s = end_s};
      r.slope = sign * 2.6 * machine.base_speed() / end_s;
      const MilResult result = run_otherwise(machine, {0.5, 0.5, 1.3}, r);
      EXPECT_FALSE(result.faults.any()) << to_string(result.first_fault);
      EXPECT_TRUE(gates_are_on(result.final_state));
    }
  }
}

// A step of torque in weakened flux: slip turns the flux of a slower model through zero while the machine's
// own remains.
TEST(MachinesRun, AMachineWhoseFluxFollowsFasterThanItsModelHasNoSensorFault) {
  for (const TestMachine& machine : test_machines) {
    for (const double torque : {-0.9, 0.9}) {
      SCOPED_TRACE(testing::Message() << machine.name << ", " << torque);
      const double begin_s = 3.0 * machine.parameters.tau_r();
      std::ostringstream points;
      points << "[[0, 0], [" << begin_s << ", "
             << torque * drive_limits(machine.parameters, machine.psi, machine.u_dc).torque << "]]";
      const MilResult result = run_otherwise(machine, {0.5, 1.5, 0.7},
                                             {.period_us = 25,
                                              .omega_m = 1.9 * machine.base_speed(),
                                              .end_s = begin_s + 0.2,
                                              .torque = points.str()});
      const bool of_currents =
          result.first_fault == Fault::current_sensor || result.first_fault == Fault::open_phase;
      EXPECT_FALSE(result.faults.any() && of_currents) << to_string(result.first_fault);
    }
  }
}

// Near the voltage limit little voltage is left to change the torque: with a transient rotor time constant of
// 70 ms its reversal takes up to 20 ms.
TEST(MachinesRun, FullTorqueReversesAtTheVoltageLimit) {
  for (const TestMachine& machine : test_machines) {
    for (const char* controller : {"dtc", "predictive", "foc"}) {
      for (const double speed : {-1.2, 1.0}) {
        SCOPED_TRACE(testing::Message() << machine.name << ", " << controller << ", " << speed);
        const double begin_s = std::max(0.3, 2.5 * machine.parameters.tau_r());
        const double torque = 0.9 * drive_limits(machine.parameters, machine.psi, machine.u_dc).torque;
        std::ostringstream points;
        points << "[[0, 0], [" << begin_s << ", " << torque << "], [" << begin_s + 0.2 << ", " << -torque
               << "]]";
        const MilResult result = run(machine, {.controller = controller,
                                               .period_us = period_us_of(machine, controller),
                                               .omega_m = speed * machine.base_speed(),
                                               .end_s = begin_s + 0.4,
                                               .torque = points.str()});
        EXPECT_FALSE(result.faults.any());
        EXPECT_LE(result.metrics[Metric::torque_silent], 10.0);
      }
    }
  }
}

// Under a switching table little of the link's voltage is across the rotor flux where the stator flux is far
// behind it: the reversal from regenerating to motoring takes longer than the torque monitor's 10 ms.
TEST(MachinesRun, FullTorqueReversesFromRegeneratingInFieldWeakening) {
  for (const TestMachine& machine : test_machines) {
    for (const double speed : {-2.0, -1.8, 1.9}) {
      SCOPED_TRACE(testing::Message() << machine.name << ", " << speed);
      const double begin_s = std::max(0.3, 2.5 * machine.parameters.tau_r());
      const double limit = drive_limits(machine.parameters, machine.psi, machine.u_dc).torque;
      const double torque = std::copysign(0.98 * limit, -speed);
      std::ostringstream points;
      points << "[[0, 0], [" << begin_s << ", " << torque << "], [" << begin_s + 0.2 << ", " << -torque
             << "]]";
      const MilResult result = run(machine, {.controller = "dtc",
                                             .period_us = period_us_of(machine, "dtc", 125),
                                             .omega_m = speed * machine.base_speed(),
                                             .end_s = begin_s + 0.3,
                                             .torque = points.str()});
      EXPECT_FALSE(result.faults.any()) << to_string(result.first_fault);
      EXPECT_LE(result.metrics[Metric::torque_silent], 10.0);
    }
  }
}

// Near breakdown a torque takes much current along the stator flux, whatever the field is. Where this current
// counted as the field's, flux priority let the flux of machines with a large stator resistance fall, and it
// stayed there, with a quarter of the torque and at last FLUX_LOST.
TEST(MachinesRun, TheFluxOfALargeStatorResistanceRisesAgainBesideRegeneratedTorque) {
  const TestMachine machine{"300 W", {111, 59.6, 0.204, 0.247, 7.13, 3, 0.01}, 1002, 1.8417};
  for (const double speed : {-1.1, 1.1}) {
    for (const int period_us : {50, 125}) {
      SCOPED_TRACE(testing::Message() << speed << ", " << period_us << " us");
      const double limit = drive_limits(machine.parameters, machine.psi, machine.u_dc).torque;
      const double torque = std::copysign(0.98 * limit, speed);
      std::ostringstream points;
      points << "[[0, 0], [0.6, " << torque << "], [0.8, " << -torque << "]]";
      const MilResult result = run(machine, {.controller = "dtc",
                                             .period_us = period_us,
                                             .omega_m = speed * machine.base_speed(),
                                             .end_s = 1.4,
                                             .torque = points.str()});
      EXPECT_FALSE(result.faults.any()) << to_string(result.first_fault);
      EXPECT_GT(result.metrics[Metric::flux_mean], 0.7 * machine.psi);
      EXPECT_GT(std::abs(result.metrics[Metric::torque_bias] - torque), 0.9 * limit);
    }
  }
}

/// What over-modulation up to a share of u_dc/√3 needs.
std::vector<std::string> up_to(double voltage_use, const std::string& controller) {
  return {"capability.voltage_use=" + std::to_string(voltage_use),
          "control." + controller + ".overmodulation=fundamental"};
}

/// Beyond base speed, with a command of the largest torque, of which the voltage allows a part: the torque
/// that is made and the one published. [N·m]
struct AtTheVoltageLimit {
  double made{};
  double published{};
};
AtTheVoltageLimit at_voltage_limit(const TestMachine& machine, const std::string& controller,
                                   const std::vector<std::string>& set) {
  const double command = 0.99 * drive_limits(machine.parameters, machine.psi, machine.u_dc).torque;
  const double begin_s = std::max(0.3, 4.0 * machine.parameters.tau_r());
  std::ostringstream points;
  points << "[[0, 0], [" << begin_s << ", " << command << "]]";
  const MilResult result = run(machine, {.controller = controller,
                                         .omega_m = 1.9 * machine.base_speed(),
                                         .end_s = begin_s + 0.4,
                                         .torque = points.str(),
                                         .set = set});
  EXPECT_FALSE(result.faults.any());
  EXPECT_EQ(result.final_state, DriveState::derated);
  return {command + result.metrics[Metric::torque_bias], result.metrics[Metric::torque_motoring]};
}

// The torque goes as the square of the voltage. At six-step itself no voltage is left for the control.
TEST(MachinesRun, OverModulationMakesMoreTorqueBeyondBaseSpeed) {
  for (const std::size_t n : {0U, 1U, 2U}) {
    const TestMachine& machine = test_machines[n];
    for (const std::string controller : {"foc", "pwm_dtc", "deadbeat", "feedback_linearisation"}) {
      SCOPED_TRACE(machine.name + (", " + controller));
      const AtTheVoltageLimit linear = at_voltage_limit(machine, controller, {});
      for (const double voltage_use : {1.04, 1.08}) {
        const AtTheVoltageLimit more = at_voltage_limit(machine, controller, up_to(voltage_use, controller));
        EXPECT_NEAR(more.made, more.published, 0.005 * more.published);
        EXPECT_NEAR(more.made, voltage_use * voltage_use * linear.made, 0.03 * linear.made);
      }
    }
  }
}

}  // namespace
}  // namespace sextant
