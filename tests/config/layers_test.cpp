#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"

namespace sextant {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string machine_line() {
  return "machine = \"" + shipped_machine + "\"\n";
}

TEST(ConfigFile, ThatCannotBeReadIsNamed) {
  const ConfigFiles files;
  EXPECT_EQ(ecu_refusal(files.path("none.toml")),
            files.path("none.toml") + ": cannot be read: No such file or directory");
  EXPECT_THAT(ecu_refusal(files.path("")), HasSubstr("it is a directory"));
}

TEST(ConfigFile, ThatIsNotTomlIsRefusedWithItsLine) {
  const ConfigFiles files;
  for (const char* bad :
       {"[control", "= 3", "flux_reference_wb = ", "a = 1\na = 2", "x = \"open", "[a]\n[a]"}) {
    SCOPED_TRACE(bad);
    const std::string file = files.write("ecu.toml", "drive_id = 1\n" + std::string{bad} + "\n");
    EXPECT_THAT(ecu_refusal(file), StartsWith(file + ":"));
    EXPECT_THAT(ecu_refusal(file), HasSubstr(": not valid TOML: "));
  }
}

TEST(ConfigFile, IntegersAreNumbers) {
  const ConfigFiles files;
  const std::string file = files.write("ecu.toml", machine_line() + "[command]\ntorque_limit_nm = 15\n");
  EXPECT_EQ(load_ecu_config(file).drive.drive.command.torque_limit, 15.0);
}

TEST(ConfigFile, SaysExactlyWhatIsWrong) {
  const ConfigFiles files;
  const std::string file =
      files.write("ecu.toml", machine_line() + "[control]\nflux_reference_wb = \"high\"\n");
  EXPECT_EQ(ecu_refusal(file),
            file + ":3: control.flux_reference_wb: expected a number from 0.01 to 10, got \"high\"");
}

TEST(ConfigFile, AllProblemsAreReportedAtOnce) {
  const ConfigFiles files;
  const std::string file = files.write(
      "ecu.toml", machine_line() + "drive_id = 1.5\n[drive]\nperiod_us = nan\n[drvie]\nperiod_us = 25\n");
  const std::string why = ecu_refusal(file);
  EXPECT_THAT(why, HasSubstr(file + ":2: drive_id: expected an integer from 0 to 65535, got 1.5\n"));
  EXPECT_THAT(why, HasSubstr(file + ":4: drive.period_us: expected a number from 1 to 100000, got nan"));
  EXPECT_THAT(why, HasSubstr(file + ":5: drvie: unknown key; the nearest known one is drive"));
}

TEST(ConfigFile, AValueWhereATableBelongsIsRefused) {
  const ConfigFiles files;
  const std::string file = files.write("ecu.toml", machine_line() + "control = 3\n");
  EXPECT_EQ(ecu_refusal(file), file + ":2: control: expected a table, got 3");
}

TEST(ConfigFile, AMisplacedKeyIsPointedToItsSection) {
  const ConfigFiles files;
  const std::string file = files.write("ecu.toml", machine_line() + "flux_reference_wb = 1.1\n");
  EXPECT_THAT(ecu_refusal(file), EndsWith("the nearest known one is control.flux_reference_wb"));
}

TEST(ConfigFile, ValuesThatContradictEachOtherAreRefusedWithTheirSection) {
  const ConfigFiles files;
  const std::string gate =
      files.write("gate.toml", machine_line() + "[command]\ntimeout_ms = 50\nlost_ms = 40\n");
  EXPECT_EQ(ecu_refusal(gate), gate + ":2: command: a command cannot be lost before it has timed out");
  const std::string load = files.write("load.toml", machine_line() + "[load]\nspeed_rad_s.value = 10\n");
  EXPECT_EQ(ecu_refusal(load), load + ":2: load: speed_rad_s is given, but kind is \"torque\"");
  const std::string flux =
      files.write("flux.toml",
                  machine_line() + "[control]\nflux_reference_wb = 0.5\n[control.dtc]\nflux_band_wb = 0.6\n");
  EXPECT_EQ(ecu_refusal(flux), flux + ":4: control.dtc: the flux band must be below the flux reference");
}

TEST(ConfigFile, ChangesKeysOfItsBaseWhichHasThePathsOfItsOwnDirectory) {
  const ConfigFiles files;
  (void)files.write("base/motor.toml",
                    "r_s_ohm = 1\nr_r_ohm = 2\nl_ls_h = 0.01\nl_lr_h = 0.01\nl_m_h = 0.1\npoles = 8\n"
                    "inertia_kg_m2 = 0.2\n");
  (void)files.write("base/ecu.toml",
                    "machine = \"motor.toml\"\n[control]\nflux_reference_wb = 0.9\ncontroller = \"dtc\"\n");
  const std::string file = files.write(
      "ecu.toml", "base = \"base/ecu.toml\"\n[control]\ncontroller = \"foc\"\n[machine]\nr_s_ohm = 3\n");
  const DriveConfig c = load_ecu_config(file, {"control.flux_reference_wb=0.8"}).drive;
  EXPECT_EQ(c.controller, "foc");
  EXPECT_EQ(c.control.flux_reference, 0.8);
  EXPECT_EQ(c.plant.plant.machine.r_s, 3.0);
  EXPECT_EQ(c.plant.plant.machine.r_r, 2.0);
}

TEST(ConfigFile, ABaseHasABaseOfItsOwn) {
  const ConfigFiles files;
  (void)files.write("first.toml", machine_line() + "drive_id = 3\n[control]\nflux_reference_wb = 0.9\n");
  (void)files.write("second.toml", "base = \"first.toml\"\ndrive_id = 4\ncontrol.controller = \"foc\"\n");
  const EcuConfig c = load_ecu_config(files.write("third.toml",
                                                  "base = \"second.toml\"\n[control]\n"
                                                  "controller = \"dtc\"\n"));
  EXPECT_EQ(c.drive_id, 4);
  EXPECT_EQ(c.drive.controller, "dtc");
  EXPECT_EQ(c.drive.control.flux_reference, 0.9);
}

TEST(ConfigFile, ABaseThatCannotBeOneIsRefusedWhereItIsNamed) {
  const ConfigFiles files;
  const auto changes = [&files](const std::string& base) {
    return files.write("ecu.toml", "drive_id = 1\nbase = " + base + "\n");
  };
  const std::string place = files.path("ecu.toml") + ":2: base: ";
  for (const char* bad : {"1", "\"\"", "{ file = \"a.toml\" }"})
    EXPECT_THAT(ecu_refusal(changes(bad)), StartsWith(place + "expected the path of a file, got ")) << bad;
  EXPECT_EQ(ecu_refusal(changes("\"none.toml\"")),
            place + "the base file " + files.path("none.toml") + " does not exist");
  (void)files.write("own.toml", "base = \"ecu.toml\"\n");
  EXPECT_THAT(ecu_refusal(changes("\"own.toml\"")),
              HasSubstr(": base: more than 8 files one behind the other, or a circle of them"));
  const std::string wrong = files.write("wrong.toml", machine_line() + "drive_id = 1.5\n");
  EXPECT_THAT(ecu_refusal(files.write("ecu.toml", "base = \"wrong.toml\"\n")),
              StartsWith(wrong + ":2: drive_id: "));
  EXPECT_THAT(ecu_refusal(shipped_ecu, {"base=own.toml"}), HasSubstr("--set: base: unknown key"));
}

TEST(ConfigFile, AMachineThatIsTooStiffForFixedStepsIsRefused) {
  const ConfigFiles files;
  // No limits follow from a machine with so little leakage.
  const std::string limits =
      "[command]\ntorque_limit_nm = 100\n[protection]\nover_current_a = 200\n"
      "[control.dtc]\ntorque_band_upper_nm = 1\ntorque_band_lower_nm = 1\n";
  const std::string stiff = "[machine]\nfile = \"" + shipped_machine + "\"\nl_ls_h = 2e-4\nl_lr_h = 2e-4\n" +
                            "r_r_ohm = 1000\n" + limits + "[plant]\nintegrator = ";
  EXPECT_THAT(ecu_refusal(files.write("fixed.toml", stiff + "\"fixed\"\n")),
              HasSubstr("plant: integrator = \"fixed\" would take"));
  EXPECT_EQ(ecu_refusal(files.write("cvode.toml", stiff + "\"cvode\"\n")), "accepted");
}

TEST(ConfigFile, APeriodSaidOnceReachesEveryoneWhoNeedsIt) {
  const DriveConfig drive =
      load_ecu_config(shipped_ecu, {"drive.period_us=62.5", "drive.actuation_delay_periods=1"}).drive;
  EXPECT_EQ(drive.direct_torque().period_ns, 62'500);
  EXPECT_EQ(drive.drive.period_ns, 62'500);
  EXPECT_EQ(drive.plant.io.period_ns, 62'500);
  EXPECT_EQ(drive.direct_torque().actuation_delay_periods, 1);
  EXPECT_EQ(drive.plant.io.actuation_delay_periods, 1);
}

TEST(ConfigOverride, TakesTomlValuesAndBareWords) {
  const EcuConfig config = load_ecu_config(
      shipped_ecu, {"control.flux_reference_wb=0.9", "plant.integrator=fixed", "realtime.required=true",
                    "can.bus=udp_multicast:239.74.163.2:43113", "dds.config_uri=\"a b\"", "drive_id = 7",
                    "load.torque_nm={ shape = \"steps\", points = [[0, 1], [2, 3]] }"});
  EXPECT_EQ(config.drive.direct_torque().flux_reference, 0.9);
  EXPECT_EQ(config.drive.plant.integrator, IntegratorKind::fixed);
  EXPECT_TRUE(config.realtime.required);
  EXPECT_EQ(config.can.bus, "udp_multicast:239.74.163.2:43113");
  EXPECT_EQ(config.dds.config_uri, "a b");
  EXPECT_EQ(config.drive_id, 7);
  EXPECT_EQ(config.drive.load.torque.points, (std::vector<ProfilePoint>{{0, 1}, {2, 3}}));
}

TEST(ConfigOverride, TheLastOneWins) {
  const EcuConfig config = load_ecu_config(shipped_ecu, {"drive_id=2", "drive_id=3"});
  EXPECT_EQ(config.drive_id, 3);
}

TEST(ConfigOverride, NamesAnotherMachine) {
  const ConfigFiles files;
  const std::string motor =
      files.write("m.toml",
                  "r_s_ohm = 1\nr_r_ohm = 2\nl_ls_h = 0.01\nl_lr_h = 0.01\nl_m_h = 0.1\npoles = 8\n"
                  "inertia_kg_m2 = 0.2\n");
  const EcuConfig config = load_ecu_config(shipped_ecu, {"machine=" + motor, "machine.r_s_ohm=3"});
  EXPECT_EQ(config.drive.plant.plant.machine.r_s, 3.0);
  EXPECT_EQ(config.drive.plant.plant.machine.pole_pairs, 4);
}

TEST(ConfigOverride, MistakesAreLaidToTheCommandLine) {
  EXPECT_EQ(ecu_refusal(shipped_ecu, {"control.flux_reference_wb=high"}),
            "--set: control.flux_reference_wb: expected a number from 0.01 to 10, got \"high\"");
  EXPECT_EQ(ecu_refusal(shipped_ecu, {"control.flux_reference_wb=90.3"}),
            "--set: control.flux_reference_wb: expected a number from 0.01 to 10, got 90.3");
  EXPECT_EQ(
      ecu_refusal(shipped_ecu, {"control.flux_refrence_wb=1"}),
      "--set: control.flux_refrence_wb: unknown key; the nearest known one is control.flux_reference_wb");
  EXPECT_EQ(
      ecu_refusal(shipped_ecu, {"plant.integrator=ode45"}),
      "--set: plant.integrator: expected \"cvode\" or \"fixed\" or \"exact\" or \"erk\", got \"ode45\"");
  EXPECT_EQ(ecu_refusal(shipped_ecu, {"command.lost_ms=20"}),
            "--set: command: a command cannot be lost before it has timed out");
  for (const char* text :
       {"drive_id", "=3", "drive_id=", "a b=3", "machine={", "drive_id=1\nx=2", "", "a..b=1"}) {
    SCOPED_TRACE(text);
    EXPECT_THAT(ecu_refusal(shipped_ecu, {text}), StartsWith("--set: "));
  }
}

// What `identify` writes: a section within a section has a file of its own, as [machine] has.
TEST(ConfigFile, OfAnInverterAndOfAnEstimateAreReadWhereTheirSectionsNameThem) {
  const ConfigFiles files;
  const std::string inverter = files.write("inverter.toml", "dead_time_us = 1.5\nvoltage_error_v = 0.25\n");
  const std::string machine = files.write("estimate.toml", "r_s_ohm = 0.5\n");
  const std::string named =
      files.write("named.toml", machine_line() +
                                    "[drive]\ninverter = \"inverter.toml\"\n[control]\nmachine_estimate = "
                                    "\"estimate.toml\"\n");
  const std::string plain = files.write("plain.toml", machine_line());
  const std::vector<std::string> sets{"drive.inverter=" + inverter, "control.machine_estimate=" + machine};
  for (const EcuConfig& config : {load_ecu_config(named), load_ecu_config(plain, sets)}) {
    EXPECT_EQ(config.drive.control.inverter.dead_time_ns, 1500);
    EXPECT_EQ(config.drive.control.inverter.voltage_error, 0.25);
    EXPECT_EQ(config.drive.control.machine.r_s, 0.5);
  }
  const std::string own = files.write(
      "own.toml", machine_line() + "[drive.inverter]\nfile = \"inverter.toml\"\ndead_time_us = 2\n");
  EXPECT_EQ(load_ecu_config(own).drive.control.inverter.dead_time_ns, 2000) << "the section's own key wins";
  EXPECT_EQ(load_ecu_config(own).drive.control.inverter.voltage_error, 0.25);
}

TEST(ConfigFile, OfAnInverterIsRefusedWithItsPlace) {
  const ConfigFiles files;
  const std::string none = files.write("none.toml", machine_line() + "[drive]\ninverter = \"no.toml\"\n");
  EXPECT_EQ(ecu_refusal(none), none + ":3: drive.inverter: the drive.inverter file " + files.path("no.toml") +
                                   " does not exist");
  const std::string bad = files.write("bad.toml", "dead_time_us = -1\ndaed_time_us = 1\n");
  const std::string why =
      ecu_refusal(files.write("uses.toml", machine_line() + "[drive]\ninverter = \"bad.toml\"\n"));
  EXPECT_THAT(why, HasSubstr(bad + ":1: dead_time_us: expected a number"));
  EXPECT_THAT(why, HasSubstr(bad + ":2: daed_time_us: unknown key"));
}

}  // namespace
}  // namespace sextant
