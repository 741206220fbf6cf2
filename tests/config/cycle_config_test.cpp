#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/profiles/drive_cycle.hpp"
#include "support/source_directory.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;

const std::string configs = SEXTANT_SOURCE_DIR "/configs";

/// A scenario on the shipped machine, with more lines from line 4 on.
std::string scenario(const std::string& lines) {
  return "name = \"test\"\nduration_s = 1\nmachine = \"" + shipped_machine + "\"\n" + lines;
}
std::string cycle_lines(const std::string& more) {
  return "[cycle]\nfile = \"" + configs + "/cycles/nycc.csv\"\ntable = \"" + configs +
         "/vehicles/passive_ev.csv\"\n" + more;
}

class CycleConfigFile : public ::testing::Test {
 protected:
  ScenarioConfig load(const std::string& lines) const {
    return load_scenario_config(files_.write("s.toml", scenario(lines)));
  }
  std::string refusal(const std::string& lines) const {
    try {
      (void)load(lines);
    } catch (const ConfigError& error) {
      return error.what();
    }
    ADD_FAILURE() << "accepted";
    return {};
  }
  const ConfigFiles files_{};
};

TEST_F(CycleConfigFile, BecomesTorqueReferenceAndImposedSpeed) {
  const ScenarioConfig config = load(cycle_lines("extrapolation = \"clip\"\n"));
  const PassiveEvLoad expected{
      {read_passive_ev_table(configs + "/vehicles/passive_ev.csv"), PassiveEvLoad::Extrapolation::clip}};
  const Profile speed{read_drive_cycle(configs + "/cycles/nycc.csv").speed};
  const Profile torque{config.scenario.torque_reference};
  ASSERT_TRUE(config.scenario.load.imposed_speed.has_value());
  const Profile wheel{*config.scenario.load.imposed_speed};
  for (std::int64_t t = 0; t < 598'000'000'000; t += 1'234'567'890) {
    EXPECT_NEAR(torque.value(t), expected.torque(speed.value(t)), 1e-6);
    EXPECT_NEAR(wheel.value(t), expected.wheel_speed(speed.value(t)), 1e-6);
  }
}

TEST_F(CycleConfigFile, IsLinearlyExtrapolatedUnlessToldOtherwise) {
  EXPECT_NEAR(load(cycle_lines("")).scenario.torque_reference.points.front().value, -140.0 / 11.0, 1e-12);
  EXPECT_EQ(load(cycle_lines("extrapolation = \"origin\"\n")).scenario.torque_reference.points.front().value,
            0.0);
}

TEST_F(CycleConfigFile, SurvivesPrintingFromAnotherPlace) {
  (void)files_.write("sub/c.csv", "time_s,speed_kmh\n0,0\n9,30\n");
  (void)files_.write("sub/p.csv", "time_s,value\n0,1\n9,2\n");
  const ScenarioConfig first =
      load(cycle_lines("file = \"sub/c.csv\"\n").replace(0, cycle_lines("").find("table"), "[cycle]\n"));
  EXPECT_EQ(first.cycle.speed.points.size(), 2U) << "the path is relative to the scenario";
  const std::string text = print_config(first);
  EXPECT_EQ(print_config(load_scenario_config(files_.write("else/where/s.toml", text))), text);
  const std::string table =
      print_config(load("[profile.torque_nm]\nshape = \"table\"\nfile = \"sub/p.csv\"\n"));
  const ScenarioConfig again = load_scenario_config(files_.write("else/where/t.toml", table));
  EXPECT_EQ(Profile{again.scenario.torque_reference}.value(4'500'000'000), 1.5);
}

TEST_F(CycleConfigFile, OfAVehicleBeginsAtRest) {
  (void)files_.write("moving.csv", "time_s,speed_kmh\n0,10\n9,30\n");
  EXPECT_THAT(refusal("vehicle = \"" + configs +
                      "/vehicles/micro_ev.toml\"\n[cycle]\nfile = \"moving.csv\"\nload = \"vehicle\"\n"),
              HasSubstr("must begin at rest"));
}

// 10 km/h on wheels of 0.2786 m are 9.97 rad/s.
TEST_F(CycleConfigFile, OfAVehicleBeginsWithTheSpeedOfItsShaft) {
  (void)files_.write("moving.csv", "time_s,speed_kmh\n0,10\n9,30\n");
  const auto begins = [](const char* speed) {
    return "vehicle = \"" + configs + "/vehicles/micro_ev.toml\"\n[cycle]\nfile = \"moving.csv\"\nload = " +
           "\"vehicle\"\n[plant]\ninitial_speed_rad_s = " + speed + "\n";
  };
  EXPECT_EQ(load(begins("9.97")).drive.plant.plant.initial.speed, 9.97);
  EXPECT_THAT(refusal(begins("-9.97")),
              HasSubstr("the cycle must begin within 1 % of the vehicle's speed, "));
  EXPECT_THAT(refusal(begins("9.8")), HasSubstr("m/s by plant.initial_speed_rad_s"));
  EXPECT_THAT(refusal(cycle_lines("[plant]\ninitial_speed_rad_s = 9.97\n")),
              HasSubstr("an imposed speed is that of the shaft from the beginning"));
}

// m g r/n sin(atan(0.08)) of the micro vehicle on each of its motors, and the road's fall as less than zero.
TEST_F(CycleConfigFile, OfAVehicleHasTheGradeOfItsFile) {
  (void)files_.write("hill.csv", "time_s,speed_kmh,grade_percent\n0,0,8\n5,10,8\n9,30,-3\n");
  const std::string hill = "vehicle = \"" + configs +
                           "/vehicles/micro_ev.toml\"\n[cycle]\nfile = \"hill.csv\"\nload = \"vehicle\"\n";
  const ScenarioConfig config = load(hill);
  const VehicleParameters& v = config.cycle.vehicle;
  const Profile torque{config.scenario.load.load_torque};
  const double weight = v.mass * 9.80665 * v.wheel_radius / v.motors;
  EXPECT_NEAR(torque.value(2'000'000'000), weight * std::sin(std::atan(0.08)), 1e-9 * weight);
  EXPECT_NEAR(torque.value(9'000'000'000), -weight * std::sin(std::atan(0.03)), 1e-9 * weight);
  EXPECT_EQ(print_config(load_scenario_config(files_.write("t.toml", print_config(config)))),
            print_config(config));
  EXPECT_THAT(
      refusal(
          "[vehicle]\nfile = \"" + configs +
          "/vehicles/micro_ev.toml\"\ngrade_percent = 2\n[cycle]\nfile = \"hill.csv\"\nload = \"vehicle\"\n"),
      HasSubstr("cycle: the cycle's file has a grade, and vehicle.grade_percent is given"));
  EXPECT_THAT(refusal("[cycle]\nfile = \"hill.csv\"\ntable = \"" + configs + "/vehicles/passive_ev.csv\"\n"),
              HasSubstr("cycle: the cycle's file has a grade, which load \"passive_ev\" cannot follow"));
}

TEST_F(CycleConfigFile, AResponseTimeNeedsAJump) {
  const std::string ramp = "[profile.torque_nm]\nshape = \"linear\"\npoints = [[0, 0], [0.5, 5], [0.5, 9]]\n";
  EXPECT_THAT(refusal(ramp + "[metrics]\nstep_s = 0.25\n"), HasSubstr("at which the torque reference jumps"));
  EXPECT_EQ(load(ramp + "[metrics]\nstep_s = 0.5\n").scenario.metrics.step_ns, 500'000'000);
}

TEST_F(CycleConfigFile, StandsAlone) {
  const std::string file = files_.path("s.toml");
  EXPECT_EQ(refusal(cycle_lines("[profile.torque_nm]\nvalue = 5\n")),
            file + ":4: cycle: give a cycle or profile.torque_nm, not both");
  EXPECT_EQ(refusal(cycle_lines("[load.torque_nm]\nvalue = 5\n")),
            file + ":4: cycle: give a cycle or load, not both");
  EXPECT_EQ(refusal(cycle_lines("[load]\nkind = \"imposed_speed\"\n")),
            file + ":4: cycle: give a cycle or load, not both");
}

TEST_F(CycleConfigFile, HasADrivelineBehindTheMotorOfAVehicleAlone) {
  const std::string shaft = "[plant.driveline]\ninertia_kg_m2 = 0.5\nstiffness_nm_rad = 3000\n";
  EXPECT_THAT(refusal(cycle_lines(shaft)), HasSubstr("cycle: an imposed speed turns the motor"));
  const std::string vehicle = "vehicle = \"" + configs + "/vehicles/micro_ev.toml\"\n[cycle]\nfile = \"" +
                              configs + "/cycles/nycc.csv\"\nload = \"vehicle\"\n";
  const ScenarioConfig config = load(vehicle + shaft);
  EXPECT_NEAR(config.scenario.cycle->driver.mass, 200 + 2 * (0.089 + 0.5) / 0.2786 / 0.2786, 1e-9);
  EXPECT_THAT(
      refusal(vehicle + shaft + "gear_ratio = 2\n"),
      HasSubstr("the gear of the vehicle is vehicle.gear_ratio: plant.driveline.gear_ratio must be 1"));
}

TEST_F(CycleConfigFile, IsRefusedWithFileLineAndKey) {
  const std::string file = files_.path("s.toml");
  EXPECT_THAT(refusal("[cycle]\nfile = \"" + configs + "/cycles/nycc.csv\"\n"),
              HasSubstr(file + ":4: cycle: load \"passive_ev\" needs a table"));
  EXPECT_THAT(refusal("[cycle]\ntable = \"" + configs + "/vehicles/passive_ev.csv\"\n"),
              HasSubstr(file + ":4: cycle: table is given, but the cycle's file is missing"));
  (void)files_.write("bad.csv", "time_s,speed_kmh\n0,0\n1,fast\n");
  EXPECT_EQ(refusal("[cycle]\nfile = \"bad.csv\"\n"),
            file +
                ":5: cycle.file: expected the path of a CSV file with the columns time_s and speed_mph, "
                "speed_kmh or speed_m_s, and grade or grade_percent of a road that is not level, got "
                "\"bad.csv\": " +
                files_.path("bad.csv") + ":3: speed_kmh must be a finite number, not \"fast\"");
  EXPECT_THAT(refusal("[cycle]\nfile = \"none.csv\"\n"),
              HasSubstr(files_.path("none.csv") + " cannot be read: No such file or directory"));
  (void)files_.write("wide.csv", "time_s,value\n0,0\n1,2e5\n");
  EXPECT_THAT(refusal("[profile.torque_nm]\nshape = \"table\"\nfile = \"wide.csv\"\n"),
              HasSubstr(files_.path("wide.csv") + ":3: value must be from -100000 to 100000, not 200000"));
  EXPECT_THAT(refusal("[profile.torque_nm]\nshape = \"table\"\n"),
              HasSubstr(":4: profile.torque_nm: a table needs the key file"));
}

TEST_F(CycleConfigFile, AVehicleComesWithItsDriver) {
  const ScenarioConfig config =
      load("vehicle = \"" + configs + "/vehicles/micro_ev.toml\"\n[cycle]\nfile = \"" + configs +
           "/cycles/nycc.csv\"\nload = \"vehicle\"\n[driver]\nbandwidth_rad_s = 2\n");
  ASSERT_TRUE(config.scenario.cycle.has_value());
  const Driver::Parameters& driver = config.scenario.cycle->driver;
  EXPECT_EQ(driver.bandwidth, 2.0);
  EXPECT_EQ(driver.wheel_radius, 0.2786);
  EXPECT_NEAR(driver.mass, 200 + 2 * 0.089 / 0.2786 / 0.2786, 1e-9) << "the rotors turn with the wheels";
  EXPECT_EQ(config.scenario.cycle->speed.points.size(), 599U);
  // Steady at Table 5's last row: 100 N·m at 80 km/h, with the fit's residual.
  EXPECT_NEAR(config.drive.plant.plant.road_load.torque(80 / 3.6 / 0.2786), 100, 0.61);
  const std::string text = print_config(config);
  EXPECT_EQ(print_config(load_scenario_config(files_.write("else/where/s.toml", text))), text);
}

TEST_F(CycleConfigFile, GearAndBrakeOfAVehicleReachShaftAndDriver) {
  const std::string cycle = "[cycle]\nfile = \"" + configs + "/cycles/nycc.csv\"\nload = \"vehicle\"\n";
  const std::string vehicle = "[vehicle]\nmass_kg = 200\nwheel_radius_m = 0.28\ngear_ratio = 4\n";
  const std::string brake = "brake_torque_nm = 300\n";
  const std::string shaft = "[plant.driveline]\ninertia_kg_m2 = 0.5\nstiffness_nm_rad = 3000\n";
  const ScenarioConfig config = load(cycle + vehicle + brake + "[driver]\nregeneration_from_m_s = 1.5\n");
  const Driver::Parameters& driver = config.scenario.cycle->driver;
  EXPECT_EQ(driver.regeneration_from, 1.5);
  EXPECT_EQ(driver.brake_torque, 75);
  EXPECT_EQ(driver.wheel_radius, 0.07);
  EXPECT_NEAR(driver.mass, 200 + 2 * 16 * 0.089 / 0.28 / 0.28, 1e-9);
  EXPECT_NEAR(config.drive.plant.plant.road_load.coupled_inertia, 100 * 0.07 * 0.07, 1e-12);
  EXPECT_EQ(load(cycle + vehicle).scenario.cycle->driver.brake_torque, 0);
  EXPECT_THAT(refusal(cycle + vehicle + brake + shaft),
              HasSubstr("cycle: vehicle.brake_torque_nm acts on the motor's shaft: it must be 0 with"));
}

TEST_F(CycleConfigFile, ADriverMayAskForWhatTheDriveHas) {
  const std::string cycle = "vehicle = \"" + configs + "/vehicles/micro_ev.toml\"\n[cycle]\nfile = \"" +
                            configs + "/cycles/nycc.csv\"\nload = \"vehicle\"\n";
  const auto limit = [](const ScenarioConfig& c) { return c.scenario.cycle->driver.torque_limit; };
  const ScenarioConfig own = load(cycle);
  EXPECT_EQ(limit(own), own.drive.drive.command.torque_limit) << "which follows from machine and link";
  EXPECT_GT(limit(own), 100);
  const std::string given = "[command]\ntorque_limit_nm = 80\n";
  EXPECT_EQ(limit(load(cycle + given)), 80);
  EXPECT_EQ(limit(load(cycle + given + "[capability]\ntorque_nm = 60\n")), 60);
  EXPECT_EQ(limit(load(cycle + given + "[driver]\ntorque_limit_nm = 50\n")), 50);
}

TEST_F(CycleConfigFile, AVehicleThatDoesNotFitIsRefused) {
  const std::string file = files_.path("s.toml");
  const std::string cycle = "[cycle]\nfile = \"" + configs + "/cycles/nycc.csv\"\nload = \"vehicle\"\n";
  EXPECT_EQ(refusal(cycle), file + ":4: cycle: load \"vehicle\" needs a vehicle: vehicle = \"FILE\"");
  EXPECT_THAT(refusal(cycle + "[vehicle]\nmass_kg = 100\n[driver]\ntorque_limit_nm = 200\n"),
              HasSubstr(file + ":9: driver: torque_limit_nm is above command.torque_limit_nm"));
  EXPECT_THAT(refusal(cycle + "[vehicle]\nmass_kg = 100\n[driver]\nperiod_ms = 1000\n"),
              HasSubstr(file + ":9: driver: the driver's bandwidth is too high for the period"));
  EXPECT_THAT(
      refusal(cycle + "table = \"" + configs + "/vehicles/passive_ev.csv\"\n[vehicle]\nmass_kg = 1\n"),
      HasSubstr("table is given, but load is \"vehicle\""));
  EXPECT_THAT(refusal(cycle_lines("[vehicle]\nmass_kg = 1\n")),
              HasSubstr("a vehicle is given, but load is \"passive_ev\""));
  EXPECT_THAT(refusal("[vehicle]\nmass_kg = 1\n"),
              HasSubstr("a vehicle is given, but no cycle that it follows"));
  EXPECT_EQ(refusal("vehicle = \"none.toml\"\n"),
            file + ":4: vehicle: the vehicle file " + files_.path("none.toml") + " does not exist");
  const std::string bad = files_.write("bad.toml", "mass_kg = -5\nwheels = 3\n");
  const std::string why = refusal("vehicle = \"bad.toml\"\n");
  EXPECT_THAT(why, HasSubstr(bad + ":1: mass_kg: expected a number from 0 to 1000000, got -5"));
  EXPECT_THAT(why, HasSubstr(bad + ":2: wheels: unknown key"));
}

TEST_F(CycleConfigFile, AFileOnTheCommandLineIsRelativeToTheWorkingDirectory) {
  const std::string relative = std::filesystem::relative(configs + "/cycles/nycc.csv").string();
  const ScenarioConfig config = load_scenario_config(
      files_.write("s.toml", scenario("")),
      {"cycle.file=" + relative, "cycle.table=\"" + configs + "/vehicles/passive_ev.csv\""});
  EXPECT_EQ(config.cycle.speed.points.size(), 599U);
}

}  // namespace
}  // namespace sextant
