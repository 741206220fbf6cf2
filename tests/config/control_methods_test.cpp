#include "sextant/config/control_methods.hpp"

#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/config/make_controller.hpp"

// A control method as somebody writes one outside of Sextant.
namespace elsewhere {

class OwnController final : public sextant::Controller<double> {
 public:
  static constexpr const char* name = "own";
  static constexpr const char* meaning = "a method for this test";
  static constexpr std::array channels{sextant::ControlChannel{"gain", "1", "its gain"}};

  struct Parameters {
    std::int32_t period_ns{25'000};
    double flux_reference{};
    double gain{2};
    double bandwidth{};

    void set_basis(const sextant::ControlSetup& basis) noexcept {
      period_ns = basis.period_ns;
      flux_reference = basis.flux_reference;
    }
    void set_defaults(const sextant::ControlSetup& basis) noexcept {
      bandwidth = 1e6 * basis.flux_reference / basis.period_ns;
    }
    [[nodiscard]] const char* validate() const noexcept {
      if (period_ns > 100'000 && gain > 1.0) return "the gain is too high for the period";
      return gain > 5.0 && flux_reference > 1.0 ? "such a gain needs less flux" : nullptr;
    }
  };

  explicit OwnController(const Parameters& parameters) : parameters_{parameters} {}

  [[nodiscard]] sextant::GatePattern step(const sextant::Measurement<double>&,
                                          sextant::ControlReference<double>) noexcept override {
    return {sextant::gates_off, parameters_.period_ns};
  }
  void reset() noexcept override {}
  [[nodiscard]] std::span<const double> channel_values() const noexcept override {
    return {&parameters_.gain, 1};
  }

 private:
  Parameters parameters_;
};

void describe(sextant::Description& d, OwnController::Parameters& p,
              const OwnController::Parameters& by_default) {
  d.number("gain", p.gain, {"", 0, 10, "of its loop"});
  d.defaulted("bandwidth_rad_s", p.bandwidth, by_default.bandwidth, {"rad/s", 1e-3, 1e3, "of its loop"});
}

class TrimmedController final : public sextant::Controller<double> {
 public:
  static constexpr const char* name = "trimmed";
  static constexpr const char* meaning = "a method that trims its mean torque where it is told to";

  struct Parameters {
    bool trims{};

    void set_basis(const sextant::ControlSetup& /*basis*/) noexcept {}
    [[nodiscard]] const char* validate() const noexcept { return nullptr; }
  };

  explicit TrimmedController(const Parameters& p) : trims_{p.trims} {}
  [[nodiscard]] sextant::GatePattern step(const sextant::Measurement<double>&,
                                          sextant::ControlReference<double>) noexcept override {
    return {sextant::gates_off, 25'000};
  }
  void reset() noexcept override {}
  [[nodiscard]] bool holds_mean_torque() const noexcept override { return trims_; }

 private:
  bool trims_;
};

void describe(sextant::Description& d, TrimmedController::Parameters& p,
              const TrimmedController::Parameters& /*by_default*/) {
  d.flag("trims", p.trims, "its mean torque");
}

}  // namespace elsewhere

namespace sextant {
namespace {

using elsewhere::OwnController;
using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const ControlMethods own{control_method<OwnController>()};

std::string refusal(const std::vector<std::string>& overrides) {
  try {
    (void)load_scenario_config(shipped_scenario, overrides, own);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ControlMethods, OfAProgramAreChosenByNameAndReadTheirTable) {
  const DriveConfig c = load_scenario_config(shipped_scenario,
                                             {"control.controller=own", "control.own.gain=3",
                                              "drive.period_us=50", "control.flux_reference_wb=1"},
                                             own)
                            .drive;
  EXPECT_EQ(c.method().name(), "own");
  const auto& p = c.parameters<OwnController>();
  EXPECT_EQ(p.gain, 3);
  EXPECT_EQ(p.period_ns, 50'000) << "shared with the drive";
  EXPECT_EQ(p.flux_reference, 1);
  EXPECT_EQ(p.bandwidth, 20);
  const auto controller = make_controller(c);
  EXPECT_EQ(controller->step({}, {}), GatePattern(gates_off, 50'000));
  ASSERT_EQ(controller->channel_values().size(), c.method().channels().size());
  EXPECT_EQ(controller->channel_values()[0], 3);
}

TEST(ControlMethods, OfAnEcuAreReadInTheSameWay) {
  const EcuConfig c = load_ecu_config(shipped_ecu, {"control.controller=own", "control.own.gain=1"}, {own});
  EXPECT_EQ(c.drive.method().name(), "own");
  EXPECT_THAT(print_config(c),
              HasSubstr("\n[control.own]\ngain = 1  # of its loop; a number from 0 to 10; default 2\n"));
}

TEST(ControlMethods, SayWhetherTheirMeanTorqueMeetsItsReference) {
  const auto holds = [](const std::vector<std::string>& overrides) {
    const ControlMethods methods{control_method<OwnController>(),
                                 control_method<elsewhere::TrimmedController>()};
    return make_controller(load_ecu_config(shipped_ecu, overrides, {methods}).drive)->holds_mean_torque();
  };
  for (const std::string name : {"foc", "pwm_dtc", "feedback_linearisation", "deadbeat"})
    EXPECT_TRUE(holds({"control.controller=" + name})) << name;
  for (const std::string name : {"dtc", "duty_ratio", "predictive"}) {
    const std::string chosen = "control.controller=" + name;
    EXPECT_TRUE(holds({chosen})) << name << " trims by default";
    EXPECT_FALSE(holds({chosen, "control." + name + ".torque_trim_ms=0"})) << name;
  }
  EXPECT_FALSE(holds({"control.controller=own", "control.own.gain=1"})) << "it does not say so";
  EXPECT_FALSE(holds({"control.controller=trimmed"}));
  EXPECT_TRUE(holds({"control.controller=trimmed", "control.trimmed.trims=true"}));
}

// One limit of the current: what the drive publishes as available is what the method may ask for.
TEST(ControlMethods, HaveTheCurrentLimitOfTheDrive) {
  const auto limit = [](const std::vector<std::string>& overrides) {
    return load_ecu_config(shipped_ecu, overrides)
        .drive.parameters<FieldOrientedController<>>()
        .current_limit;
  };
  EXPECT_EQ(limit({"drive.current_limit_a=60"}), 60.0);
  EXPECT_EQ(limit({"protection.over_current_a=120"}), 96.0) << "it follows from the trip level";
}

/// The names of Sextant's own methods and of this test's.
std::string choices() {
  std::string text;
  for (const auto& method : control_methods()) text += '"' + std::string{method->name()} + "\" or ";
  return text + "\"own\"";
}

TEST(ControlMethods, ArePrintedWithTheirDefaultsAndReadBack) {
  const ConfigFiles files;
  const std::string text = print_config(load_scenario_config(
      shipped_scenario, {"control.controller=own", "control.own.gain=0.5", "control.flux_reference_wb=1"},
      own));
  std::string meanings = "control method; ";
  for (const auto& method : control_methods())
    meanings += method->name() + std::string{": "} + method->meaning() + "; ";
  EXPECT_THAT(text, HasSubstr("controller = \"own\"  # " + meanings + "own: a method for this test; " +
                              choices() + "; default \"dtc\"\n"));
  EXPECT_EQ(print_config(load_scenario_config(files.write("printed.toml", text), {}, own)), text);
  EXPECT_THAT(config_json(load_scenario_config(shipped_scenario,
                                               {"control.own.gain=7.5", "control.flux_reference_wb=1"}, own)),
              HasSubstr("\"control.own.gain\": 7.5"));
}

TEST(ControlMethods, AreRefusedWithFileAndLine) {
  const ConfigFiles files;
  const std::string head = "name = \"x\"\nduration_s = 1\nmachine = \"" + shipped_machine + "\"\n";
  const std::string file = files.write("own.toml", head + "[control.own]\ngain = 11\n");
  try {
    (void)load_scenario_config(file, {}, own);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr(file + ":5: control.own.gain: expected a number from 0 to 10, got 11"));
  }
  EXPECT_THAT(refusal({"control.own.gian=1"}), EndsWith("the nearest known one is control.own.gain"));
  EXPECT_THAT(refusal({"control.own.x=1"}), EndsWith("those of control.own are bandwidth_rad_s, gain"))
      << "where the table itself is the nearest name";
  EXPECT_THAT(refusal({"control.dtc.foo=1"}),
              AllOf(HasSubstr("flux_band_wb"), HasSubstr("sector_start_deg")));
  EXPECT_THAT(refusal({"control.controller=nonsense"}),
              HasSubstr("expected " + choices() + ", got \"nonsense\""));
}

TEST(ControlMethods, BlockNothingByDefaultsWhileAnotherIsChosen) {
  const std::string slow = "drive.period_us=125";
  EXPECT_EQ(refusal({slow}), "accepted");
  EXPECT_THAT(refusal({slow, "control.controller=own"}), HasSubstr("control.own: the gain is too high"));
  EXPECT_THAT(refusal({slow, "control.own.gain=2"}), HasSubstr("control.own: the gain is too high"));
  EXPECT_EQ(refusal({slow, "control.own.gain=1"}), "accepted");
  EXPECT_THAT(refusal({slow, "control.own.gain=11"}), HasSubstr("expected a number from 0 to 10"));
}

TEST(ControlMethods, BlockNothingByDerivedValuesWhileAnotherIsChosen) {
  // The flux that the link can feed leads to a bandwidth beyond the range of its key.
  const std::vector<std::string> fast{"drive.period_us=1", "control.flux_reference_wb=1.05"};
  EXPECT_EQ(refusal(fast), "accepted");
  EXPECT_THAT(refusal({fast[0], fast[1], "control.controller=own"}),
              HasSubstr("control.own.bandwidth_rad_s: missing"));
}

TEST(ControlMethods, ThatAreNotUsedDoNotBlockThePrintedConfiguration) {
  const ConfigFiles files;
  const std::string text = print_config(load_scenario_config(shipped_scenario, {"drive.period_us=125"}, own));
  EXPECT_EQ(print_config(load_scenario_config(files.write("printed.toml", text), {}, own)), text);
}

TEST(ControlMethods, AreValidatedWhereAKeyIsGivenThoughAnotherIsChosen) {
  EXPECT_THAT(refusal({"control.own.gain=6"}), HasSubstr("control.own: such a gain needs less flux"));
  EXPECT_THAT(
      refusal({"control.controller=own", "control.dtc.flux_band_wb=0.9", "control.flux_reference_wb=0.8"}),
      HasSubstr("control.dtc: the flux band must be below the flux reference"));
}

TEST(ControlMethods, HaveTheirChannelsAmongTheSignalsOfATrace) {
  EXPECT_EQ(
      refusal({"control.controller=own", "control.flux_reference_wb=1", "trace.signals=[\"control/gain\"]"}),
      "accepted");
  EXPECT_THAT(
      refusal({"trace.signals=[\"control/gain\"]"}),
      HasSubstr("trace: signal \"control/gain\" belongs to another controller than control.controller"));
  EXPECT_THAT(refusal({"trace.signals=[\"control/gian\"]"}),
              HasSubstr("the nearest known one is \"control/gain\""));
}

/// A method with any name and channels.
class NamedMethod final : public ControlMethod {
 public:
  NamedMethod(const char* name, std::span<const ControlChannel> channels)
      : name_{name}, channels_{channels} {}
  /// The channels are not owned.
  static Cloned<ControlMethod> owned(const char* name, std::span<const ControlChannel> channels = {}) {
    return Cloned<ControlMethod>{std::make_unique<NamedMethod>(name, channels)};
  }

  [[nodiscard]] const char* name() const noexcept override { return name_; }
  [[nodiscard]] const char* meaning() const noexcept override { return "a method for this test"; }
  [[nodiscard]] std::span<const ControlChannel> channels() const noexcept override { return channels_; }
  void describe_table(Section /*table*/, const ControlSetup& /*setup*/) override {}
  [[nodiscard]] std::unique_ptr<Controller<double>> make() const override { return nullptr; }
  [[nodiscard]] std::unique_ptr<ControlMethod> clone() const override {
    return std::make_unique<NamedMethod>(*this);
  }
  [[nodiscard]] std::unique_ptr<ControlMethod> untouched() const override { return clone(); }

 private:
  const char* name_;
  std::span<const ControlChannel> channels_;
};

TEST(ControlMethods, NeedNamesOfTheirOwn) {
  for (const char* name :
       {"dtc", "machine_estimate", "r_s_per_k", "flux_reference_wb", "controller", "", "a.b", "a b"}) {
    SCOPED_TRACE(name);
    EXPECT_THROW((void)with_own(control_methods(), {NamedMethod::owned(name)}), std::invalid_argument);
  }
  EXPECT_EQ(with_own(control_methods(), own).back()->name(), std::string{"own"});
}

TEST(ControlMethods, NeedNamesForTheirChannels) {
  const auto refused = [](std::vector<ControlChannel> channels) -> std::string {
    try {
      (void)with_own(control_methods(), {NamedMethod::owned("own", channels)});
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refused({{"i_d_a", "A", ""}, {"i_q_a", "A", ""}}), "accepted");
  for (const char* name : {"", "a/b", "torque_comparator", "flux_comparator"}) {
    EXPECT_THAT(refused({{"i_d_a", "A", ""}, {name, "A", ""}}),
                HasSubstr("channel \"" + std::string{name} + "\" of the control method \"own\""));
  }
  EXPECT_THAT(refused({{"i_d_a", "A", ""}, {"i_d_a", "A", ""}}), HasSubstr("channel \"i_d_a\""));
}

TEST(ControlMethods, KeepTheirParametersWhereTheyAreCopied) {
  ControlMethods methods{control_method<OwnController>()};
  methods[0]->parameters<OwnController>().gain = 3;
  ControlMethods copies = methods;
  copies[0]->parameters<OwnController>().gain = 4;
  EXPECT_EQ(methods[0]->parameters<OwnController>().gain, 3);
  EXPECT_EQ(copies[0]->parameters<OwnController>().gain, 4);
  EXPECT_EQ(untouched(copies)[0]->parameters<OwnController>().gain, 2) << "its default";
  copies = methods;
  EXPECT_EQ(copies[0]->parameters<OwnController>().gain, 3);
}

TEST(ControlMethods, GiveTheParametersOfTheirOwnControllersOnly) {
  const ControlMethods methods{control_method<OwnController>()};
  EXPECT_THAT(
      [&methods] { (void)methods[0]->parameters<FieldOrientedController<>>(); },
      ThrowsMessage<std::logic_error>("the control method \"own\" has no parameters of the class asked for"));
  EXPECT_THAT([] { (void)DriveConfig{}.parameters<OwnController>(); },
              ThrowsMessage<std::logic_error>("there is no control method \"own\""));
}

TEST(ControlMethods, OfSextantHaveTwoListsOnly) {
  const ControlMethods methods = control_methods();
  EXPECT_EQ(methods.size(),
            std::tuple_size_v<ControllerList<double>> + std::tuple_size_v<CommissioningList<double>>);
  EXPECT_EQ(methods.front()->name(), DriveConfig{}.controller) << "the first is the default";
}

}  // namespace
}  // namespace sextant
