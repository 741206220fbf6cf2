// Every key of every kind of file, wrong once in every way. The cases are made from the descriptions that the
// reader itself walks, so that a new key is covered by describing it.

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;

/// TOML values that a key of some kind must refuse.
struct WrongValues {
  using List = std::vector<std::string>;

  List operator()(const NumberKind& f) const {
    return {"\"high\"",
            "true",
            "nan",
            "inf",
            "-inf",
            "[1.0]",
            "{ x = 1 }",
            "2026-01-01",
            std::to_string(f.range.min - 1.0 - std::abs(f.range.min)),
            std::to_string(f.range.max + 1.0 + std::abs(f.range.max))};
  }
  List operator()(const IntegerKind& f) const {
    return {"\"1\"",
            "false",
            "1.5",
            "1.0",
            "nan",
            "[1]",
            "{ x = 1 }",
            std::to_string(f.range.min - 1),
            std::to_string(f.range.max + 1)};
  }
  List operator()(const FlagKind&) const { return {"\"true\"", "1", "0.0", "[true]", "{ x = true }"}; }
  List operator()(const TextKind& f) const {
    List list{"1", "1.5", "true", "[\"a\"]", "{ x = \"a\" }", "2026-01-01"};
    if (!f.may_be_empty) list.emplace_back("\"\"");
    return list;
  }
  List operator()(const ChoiceKind& f) const {
    return {"\"nonsense\"", "\"\"", "1", "true", "[\"" + f.names.front() + "\"]", "{ x = 1 }"};
  }
  List operator()(const PointsKind& f) const {
    const std::string below = std::to_string(f.first.min - 1.0);
    const std::string above = std::to_string(2.0 * f.second.max);
    return {"1",
            "\"a\"",
            "true",
            "[0, 1]",
            "[[0]]",
            "[[0, 1, 2]]",
            "[[0, \"a\"]]",
            "[[0, nan]]",
            "[[inf, 1]]",
            "[[" + below + ", 1]]",
            "[[0, " + above + "]]",
            "{ x = 1 }"};
  }
  List operator()(const FileKind&) const {
    return {"1", "true", "\"\"", "[\"a.csv\"]", "{ x = 1 }", "\"nowhere.csv\"", "\".\"", "\"wrong.toml\""};
  }
  List operator()(const NamesKind& f) const {
    return {"1", "true", "\"" + f.known.front() + "\"", "[]", "[1]", "[\"nonsense\"]", "{ x = 1 }"};
  }
};

/// A complete file of one kind, in which single lines can be changed.
struct Kind {
  std::string name;
  Schema schema;
  std::string text;
  std::function<std::string(const std::string& file)> load;  // reads the file and prints it again
  /// Keys whose other value in IsSetByItsOwnValue contradicts another key of the same file.
  std::vector<std::string> at_odds;
};

template <class Config>
Schema schema_of(Config& config) {
  Schema schema;
  describe(Section{schema}, config);
  return schema;
}

std::vector<Kind> kinds_by_their_own_keys() {
  static EcuConfig ecu = load_ecu_config(shipped_ecu);
  static PlantConfig plant = load_plant_config(shipped_plant);
  static ScenarioConfig scenario = load_scenario_config(shipped_scenario);
  return {{"ecu",
           schema_of(ecu),
           print_config(ecu),
           [](const std::string& file) { return print_config(load_ecu_config(file)); },
           {"load.torque_nm.shape", "power_stage", "realtime.wake_every_periods"}},
          {"plant",
           schema_of(plant),
           print_config(plant),
           [](const std::string& file) { return print_config(load_plant_config(file)); },
           {"machine.r_r_ohm", "drive.actuation_delay_periods", "load.torque_nm.shape",
            "realtime.wake_every_periods"}},
          {"scenario",
           schema_of(scenario),
           print_config(scenario),
           [](const std::string& file) { return print_config(load_scenario_config(file)); },
           {"load.kind", "profile.torque_nm.shape", "profile.torque_nm.value", "cycle.file", "cycle.load",
            "cycle.table", "vehicle.mass_kg", "driver.period_ms", "driver.bandwidth_rad_s",
            "metrics.window_from_s", "metrics.step_s", "expect.fault_from_s", "expect.fault_to_s",
            "expect.torque_ripple_pp_nm.min", "expect.torque_bias_nm.min", "expect.response_time_ms.min",
            "expect.flux_mean_wb.min", "expect.peak_current_a.min", "trace.signals"}}};
}

/// The same with the keys at odds of what all kinds have, and of what those with a drive have.
std::vector<Kind> kinds() {
  std::vector<Kind> list = kinds_by_their_own_keys();
  const auto add = [](Kind& kind, const std::vector<std::string>& keys) {
    kind.at_odds.insert(kind.at_odds.end(), keys.begin(), keys.end());
  };
  for (Kind& kind : list) {
    add(kind, {"machine.l_ls_h",
               "machine.l_lr_h",
               "machine.l_m_h",
               "machine.x_ls_ohm",
               "machine.x_lr_ohm",
               "machine.x_m_ohm",
               "machine.circuit",
               "machine.x_sigma_ohm",
               "machine.l_sigma_h",
               "machine.r_s_ohm",
               "load.speed_rad_s.shape",
               "load.speed_rad_s.value",
               "load.speed_rad_s.points",
               "load.speed_rad_s.file",
               "plant.sensors.sampling_lead_us",
               "plant.sensors.sampling_skew_us",
               "plant.sensors.current.bits",
               "plant.sensors.voltage.bits",
               "plant.inverter.dead_time_us",
               "plant.inverter.minimum_pulse_us",
               "plant.saturation.points",
               "plant.link.capacitance_f",
               "plant.link.source_ohm",
               "plant.link.source_h",
               "plant.link.source_diode",
               "plant.link.chopper_ohm",
               "plant.link.chopper_on_v",
               "plant.link.chopper_off_v",
               "plant.link.precharge_ohm",
               "plant.link.initial_v",
               "plant.link.contactor_share",
               "plant.sensors.temperature.gain_error",
               "plant.sensors.temperature.offset_k",
               "plant.sensors.temperature.noise_k",
               "plant.sensors.temperature.step_k",
               "plant.sensors.temperature.time_constant_ms",
               "plant.inverter.losses.cold_c",
               "plant.inverter.losses.hot_c",
               "plant.inverter.losses.energy_voltage_v",
               "plant.inverter.losses.switch_exponent",
               "plant.inverter.losses.diode_exponent",
               "plant.inverter.losses.switch_network",
               "plant.inverter.losses.diode_network",
               "plant.inverter.losses.case_network",
               "plant.inverter.losses.ambient_c",
               "plant.inverter.losses.case_c",
               "plant.inverter.losses.switch_hot_v",
               "plant.inverter.losses.diode_hot_v",
               "plant.inverter.losses.turn_on_hot_mj",
               "plant.inverter.losses.turn_off_hot_mj",
               "plant.inverter.losses.recovery_hot_mj",
               "plant.thermal.winding_j_per_k",
               "plant.thermal.rotor_j_per_k",
               "plant.thermal.housing_j_per_k",
               "plant.thermal.winding_to_rotor_w_per_k",
               "plant.thermal.winding_to_housing_w_per_k",
               "plant.thermal.rotor_to_housing_w_per_k",
               "plant.thermal.winding_to_ambient_w_per_k",
               "plant.thermal.rotor_to_ambient_w_per_k",
               "plant.thermal.housing_to_ambient_w_per_k",
               "plant.thermal.ambient_c",
               "plant.thermal.winding_c",
               "plant.thermal.rotor_c",
               "plant.thermal.housing_c",
               "plant.thermal.reference_c",
               "plant.thermal.winding_per_k",
               "plant.thermal.rotor_per_k",
               "plant.thermal.step_ms",
               "plant.driveline.inertia_kg_m2",
               "plant.driveline.stiffness_nm_rad",
               "plant.driveline.damping_nm_s_rad",
               "plant.driveline.backlash_rad",
               "plant.driveline.gear_ratio"});
    if (kind.name == "plant") continue;
    add(kind, {"machine.reactance_frequency_hz",
               "drive.period_us",
               "drive.sampling_lead_us",
               "drive.inverter.dead_time_us",
               "drive.inverter.minimum_pulse_us",
               "drive.current_limit_a",
               "control.flux_reference_wb",
               "control.foc.bandwidth_rad_s",
               "control.pwm_dtc.bandwidth_rad_s",
               "control.feedback_linearisation.bandwidth_rad_s",
               "control.commissioning.lowest_tone_hz",
               "control.commissioning.highest_tone_hz",
               "control.machine_estimate.r_s_ohm",
               "control.machine_estimate.x_sigma_ohm",
               "control.machine_estimate.l_sigma_h",
               "torque_monitor.machine.x_sigma_ohm",
               "torque_monitor.machine.l_sigma_h",
               "command.timeout_ms",
               "command.status_timeout_ms",
               "capability.base_speed_rad_s",
               "capability.low_voltage_zero_v",
               "capability.high_voltage_v",
               "capability.high_voltage_zero_v",
               "capability.ready_voltage_v",
               "control.r_s_per_k",
               "plant.measures_winding_temperature",
               "protection.over_current_a",
               "protection.dc_over_voltage_v",
               "protection.over_speed_rad_s",
               "protection.dc_under_voltage_v",
               "protection.winding.warning_c",
               "drive.anti_jerk.gain_nm_s_rad",
               "plant.initial_speed_rad_s",
               "plant.u_dc_v"});
  }
  return list;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream{text};
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

/// Index of the line of a printed file that holds the key, set or not.
std::size_t line_of(const std::vector<std::string>& lines, const std::string& path) {
  const std::size_t dot = path.rfind('.');
  const std::string table = dot == std::string::npos ? "" : path.substr(0, dot);
  const std::string key = path.substr(dot == std::string::npos ? 0 : dot + 1) + " =";
  std::string here;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].starts_with("[")) here = lines[i].substr(1, lines[i].size() - 2);
    if (here == table && (lines[i].starts_with(key) || lines[i].starts_with("# " + key))) return i;
  }
  ADD_FAILURE() << path << " is not printed";
  return 0;
}

std::string last_part(const std::string& path) {
  return path.substr(path.rfind('.') + 1);
}

/// A choice among one name.
bool has_one_value_only(const Field& field) {
  const ChoiceKind* const choice = std::get_if<ChoiceKind>(&field.kind);
  return choice != nullptr && choice->names.size() == 1;
}

/// Expects the file to be refused, and returns why.
std::string refusal(const Kind& kind, const std::string& file) {
  try {
    kind.load(file);
  } catch (const ConfigError& error) {
    return error.what();
  }
  ADD_FAILURE() << "accepted";
  return {};
}

class EveryKey : public ::testing::TestWithParam<std::size_t> {
 protected:
  const Kind kind_ = kinds()[GetParam()];
  const ConfigFiles files_{};
};

TEST_P(EveryKey, IsRefusedWithFileLineAndKeyWhenItsValueIsWrong) {
  int cases = 0;
  for (const Field& field : kind_.schema.fields) {
    for (const std::string& value : std::visit(WrongValues{}, field.kind)) {
      SCOPED_TRACE(field.path + " = " + value);
      std::vector<std::string> lines = lines_of(kind_.text);
      const std::size_t line = line_of(lines, field.path);
      lines[line] = last_part(field.path) + " = " + value;
      const std::string file = files_.write("wrong.toml", joined(lines));
      EXPECT_THAT(refusal(kind_, file),
                  HasSubstr(file + ":" + std::to_string(line + 1) + ": " + field.path + ": expected "));
      ++cases;
    }
  }
  EXPECT_GT(cases, 300);
}

TEST_P(EveryKey, IsNamedWhenItIsMisspelt) {
  for (const Field& field : kind_.schema.fields) {
    SCOPED_TRACE(field.path);
    std::vector<std::string> lines = lines_of(kind_.text);
    const std::size_t line = line_of(lines, field.path);
    lines[line] = last_part(field.path) + "z = 1";
    const std::string file = files_.write("misspelt.toml", joined(lines));
    EXPECT_THAT(refusal(kind_, file), HasSubstr(file + ":" + std::to_string(line + 1) + ": " + field.path +
                                                "z: unknown key; the nearest known one is " + field.path));
  }
}

TEST_P(EveryKey, ThatIsRequiredIsMissedByName) {
  int required = 0;
  for (const Field& field : kind_.schema.fields) {
    if (!field.required) continue;
    SCOPED_TRACE(field.path);
    std::vector<std::string> lines = lines_of(kind_.text);
    lines[line_of(lines, field.path)].clear();
    const std::string file = files_.write("missing.toml", joined(lines));
    EXPECT_THAT(refusal(kind_, file), HasSubstr(file + ": " + field.path + ": missing, expected "));
    ++required;
  }
  EXPECT_GT(required, 3);
}

TEST_P(EveryKey, HasAMeaningAndSurvivesTheRoundTrip) {
  for (const Field& field : kind_.schema.fields) EXPECT_FALSE(field.meaning.empty()) << field.path;
  EXPECT_EQ(kind_.load(files_.write("printed.toml", kind_.text)), kind_.text);
}

TEST_P(EveryKey, IsSetByItsOwnValue) {
  // Two different values of each key print differently: no key is bound to nothing or to its neighbour's
  // member.
  struct Other {
    std::string operator()(const NumberKind& f) const {
      return std::to_string(0.4 * f.range.min + 0.6 * f.range.max);
    }
    std::string operator()(const IntegerKind& f) const {
      return std::to_string(now == Value{f.range.max} ? f.range.min : f.range.max);
    }
    std::string operator()(const FlagKind&) const { return now == Value{true} ? "false" : "true"; }
    std::string operator()(const TextKind&) const { return "\"another \\\" text\""; }
    std::string operator()(const ChoiceKind& f) const {
      const auto another = std::find_if(f.names.begin(), f.names.end(),
                                        [this](const std::string& name) { return now != Value{name}; });
      return "\"" + (another == f.names.end() ? f.names.front() : *another) + "\"";
    }
    std::string operator()(const PointsKind&) const { return "[[0.0, 1.0], [2.0, 3.5]]"; }
    std::string operator()(const FileKind& f) const {
      const bool is_cycle = f.columns.find("speed_mph") != std::string::npos;
      const bool is_profile = f.columns == "time_s,value";
      const std::string text = is_cycle     ? "time_s,speed_m_s\n0,0\n1,2\n"
                               : is_profile ? "time_s,value\n0,0\n1,2\n"
                                            : f.columns + "\n10,25,241\n20,36,342\n";
      return "\"" + files.write("other.csv", text) + "\"";
    }
    std::string operator()(const NamesKind& f) const { return "[\"" + f.known.back() + "\"]"; }
    const ConfigFiles& files;
    std::optional<Value> now;
  };
  std::vector<std::string> refused;
  for (const Field& field : kind_.schema.fields) {
    SCOPED_TRACE(field.path);
    std::vector<std::string> lines = lines_of(kind_.text);
    const std::size_t line = line_of(lines, field.path);
    lines[line] = last_part(field.path) + " = " + std::visit(Other{files_, field.member.get()}, field.kind);
    const std::string file = files_.write("other.toml", joined(lines));
    std::vector<std::string> printed;
    try {
      printed = lines_of(kind_.load(file));
    } catch (const ConfigError&) {
      refused.push_back(field.path);  // inside its own range, but at odds with another key
      continue;
    }
    ASSERT_EQ(printed.size(), lines.size());
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (i != line) {
        EXPECT_EQ(printed[i], lines[i]) << "another key moved";
      }
    }
    if (!has_one_value_only(field)) {
      EXPECT_NE(printed[line], lines_of(kind_.text)[line]) << "the key sets nothing";
    }
  }
  EXPECT_THAT(refused, ::testing::UnorderedElementsAreArray(kind_.at_odds))
      << "a key that contradicts another one is named in kinds(), and no key that does not";
}

INSTANTIATE_TEST_SUITE_P(Files, EveryKey, ::testing::Values(0U, 1U, 2U),
                         [](const auto& case_info) { return kinds()[case_info.param].name; });

}  // namespace
}  // namespace sextant
