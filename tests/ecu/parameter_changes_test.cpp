// Parameters that the running drive takes: which may change when, from which period on, and that a drive
// which has taken them is the drive that is started with them.

#include "ecu/parameters/parameter_changes.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "ecu/tasks/control_task.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/power_stage/live_power_stage.hpp"
#include "sextant/virtual_time/digest.hpp"
#include "support/source_directory.hpp"

namespace sextant::ecu {
namespace {

using Settings = std::vector<std::string>;
using Outcome = ParameterChanges::Outcome;

/// A drive of 100 µs with a plant whose shaft is held at 60 rad/s, a wake-up a period.
EcuConfig configuration(const std::string& method, const Settings& more = {}) {
  Settings settings{"control.controller=" + method, "drive.period_us=100",    "realtime.wake_every_periods=1",
                    "realtime.watchdog_ms=10",      "plant.integrator=fixed", "load.kind=imposed_speed",
                    "load.speed_rad_s.value=60"};
  settings.insert(settings.end(), more.begin(), more.end());
  return load_ecu_config(SEXTANT_SOURCE_DIR "/configs/ecu.toml", settings);
}

/// A drive with its plant and a vehicle that demands a torque.
class Loop {
 public:
  explicit Loop(const EcuConfig& config)
      : config_{config},
        plant_{config.drive.plant, config.drive.load.parameters()},
        drive_{config.drive},
        shared_{config.drive.drive.period_ns, 1},
        control_{{config.drive.drive.period_ns, 1}, drive_.drive(), shared_} {}

  /// So many control periods. The first three commands disable, which ends the lockout.
  void run(int periods, std::optional<double> torque) {
    for (int k = 0; k < periods; ++k) {
      t_ns_ += config_.drive.drive.period_ns;
      TorqueCommand<double> command{.torque_limit = 1000, .received_ns = t_ns_, .sequence = ++sequence_};
      command.e2e = E2eState::valid;
      command.enable = torque && sequence_ > 3;
      command.torque = command.enable ? *torque : 0;
      disables_ += command.enable ? 0U : 1U;
      command.disables = disables_;
      shared_.command.store(command);
      wake_up();
    }
  }
  /// The same without a command.
  void wait(int periods) {
    for (int k = 0; k < periods; ++k) {
      t_ns_ += config_.drive.drive.period_ns;
      wake_up();
    }
  }

  [[nodiscard]] SharedState& shared() noexcept { return shared_; }
  [[nodiscard]] const Telemetry<double>& now() const noexcept { return control_.last(); }
  [[nodiscard]] std::uint64_t digest() const noexcept { return digest_.value(); }

 private:
  void wake_up() {
    NoProbe probe;
    control_.wake_up(t_ns_, t_ns_, 0, plant_.io(), probe);
    digest_.add(now());
  }

  EcuConfig config_;
  LivePowerStage plant_;
  ConfiguredDrive drive_;
  SharedState shared_;
  ControlTask control_;
  Digest digest_{};
  std::uint64_t sequence_{0};
  std::uint32_t disables_{0};
  std::int64_t t_ns_{0};
};

constexpr int to_torque = 6000;  // periods, flux included

/// A loop of a method whose parameters may be set.
struct Running {
  explicit Running(const std::string& method, const Settings& own = {})
      : loop{configuration(method, own)},
        changes{configuration(method, own),
                [method, own](Settings more) {
                  more.insert(more.begin(), own.begin(), own.end());
                  return configuration(method, more);
                },
                loop.shared()} {}

  /// The sentence of a refusal, before the control thread is asked; "offered" without one.
  std::string refusal(const Settings& settings) {
    try {
      return changes.offer(settings) ? "offered" : "unchanged";
    } catch (const std::runtime_error& problem) {
      return problem.what();
    }
  }

  Loop loop;
  ParameterChanges changes;
};

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const auto& method : control_methods()) {
    if (method->make()->takes_parameters()) names.emplace_back(method->name());
  }
  return names;
}

TEST(ParameterChanges, EveryMethodOfTorqueControlTakesParameters) {
  EXPECT_EQ(method_names(), (std::vector<std::string>{"dtc", "duty_ratio", "predictive", "pwm_dtc",
                                                      "feedback_linearisation", "foc", "deadbeat"}));
}

TEST(ParameterChanges, EqualParametersUnderTorqueLeaveEveryBit) {
  for (const std::string& method : method_names()) {
    SCOPED_TRACE(method);
    const EcuConfig config = configuration(method);
    Loop plain{config};
    Loop set{config};
    ConfiguredDrive equal{config.drive};
    plain.run(to_torque, 40);
    set.run(to_torque, 40);
    ASSERT_EQ(set.now().state, DriveState::torque);
    set.shared().parameters.store({1, Changes::always, &equal.drive()});
    plain.run(500, 60);
    set.run(500, 60);
    EXPECT_EQ(set.shared().parameter_sets.load(), 1U);
    EXPECT_EQ(set.digest(), plain.digest());
  }
}

/// Another value of a key as text; empty where there is none.
struct OtherValue {
  double factor;
  std::optional<Value> now;

  std::string operator()(const NumberKind& k) const {
    const double x = now ? std::get<double>(*now) : 0;
    const bool scales = std::isfinite(x) && x != 0;
    const double value = scales ? x * factor : k.range.min + 0.1 * factor * (k.range.max - k.range.min);
    return value >= k.range.min && value <= k.range.max ? std::to_string(value) : "";
  }
  std::string operator()(const IntegerKind& k) const {
    return std::to_string((now ? std::get<std::int64_t>(*now) : k.range.min) + 1);
  }
  std::string operator()(const FlagKind&) const { return now == Value{true} ? "false" : "true"; }
  std::string operator()(const ChoiceKind& k) const {
    return now == Value{k.names.front()} ? k.names.back() : k.names.front();
  }
  template <class Kind>
  std::string operator()(const Kind&) const {
    return "";
  }
};

/// Torque from the first period on, above base speed, with real sensors, so that a short run shows what a key
/// does.
const Settings eventful{"drive.magnetise_first=false",
                        "load.speed_rad_s.value=160",
                        "plant.sensors.current.noise_a=0.3",
                        "plant.sensors.current.phase_a.offset_a=0.4",
                        "protection.winding.nominal_current_a=6",
                        "protection.winding.time_constant_s=20",
                        "protection.winding.ambient_c=120",
                        "drive.flux_optimum=min_loss",
                        "drive.iron_loss_resistance_ohm=300",
                        "drive.anti_jerk.gain_nm_s_rad=5"};

Settings with(const std::string& setting) {
  Settings settings{eventful};
  settings.push_back(setting);
  return settings;
}

/// Torque, its reversal above base speed, and a vehicle that falls silent.
void drive_through(Loop& loop) {
  loop.run(350, 40);
  loop.run(250, -60);
  loop.wait(700);
}

/// What happens to the plant meanwhile.
const std::vector<Settings> events{
    {},
    {"plant.faults.kind=current_drift", "plant.faults.drift_a_s=400", "plant.faults.at_s=0.02"},
    {"plant.faults.kind=phases_swapped", "plant.faults.at_s=0.02"},
    {"plant.faults.kind=open_phase", "plant.faults.at_s=0.02"},
    {"plant.faults.kind=current_stuck", "plant.faults.at_s=0.02"},
    {"plant.faults.kind=speed_jump", "plant.faults.jump_rad_s=60", "plant.faults.at_s=0.02"},
    {"plant.faults.kind=speed_jump", "plant.faults.jump_rad_s=2", "plant.faults.at_s=0.02",
     "load.speed_rad_s.value=20"},
    {"plant.faults.kind=link_sag", "plant.faults.sag_v=250", "plant.faults.ramp_ms=10",
     "plant.faults.at_s=0.02"},
};

Settings joined(Settings a, const Settings& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// Of a run under each of the events.
using Digests = std::vector<std::uint64_t>;

Digests digests_of(const std::string& method, const Settings& settings) {
  Digests digests;
  for (const Settings& event : events) {
    Loop loop{configuration(method, joined(settings, event))};
    drive_through(loop);
    digests.push_back(loop.digest());
  }
  return digests;
}

/// Keys that only what does not happen here would show: a silent transmitter, commands that contradict
/// themselves, a link that rises, readings beyond their sensor, a flux that is lost, a torque that deviates.
const std::vector<std::string> shown_by_nothing{
    "command.status_timeout_ms",    "command.status_lost_ms",     "command.blocked_limit",
    "protection.dc_over_voltage_v", "protection.current_range_a", "protection.voltage_range_v",
    "protection.speed_range_rad_s", "protection.flux_lost_share", "protection.flux_lost_torque_nm",
    "protection.flux_lost_ms",      "torque_monitor.enabled",     "torque_monitor.limit_share",
    "torque_monitor.wrong_sign_nm"};

bool is_named(const std::string& key, const std::vector<std::string>& names) {
  return std::find(names.begin(), names.end(), key) != names.end();
}

/// A key with another value, `key=value`, and the runs of a drive that is started with it.
struct Tried {
  std::string key;
  std::string setting;
  Digests digests{};
  bool shows{};  ///< one of its runs is another one than without the key
};

/// With the first of several values that shows; else with the first that the configuration takes, if any.
std::optional<Tried> tried(const Field& field, const std::string& method, const Digests& plain) {
  std::optional<Tried> best;
  for (const double factor : {0.02, 40.0, 0.3, 0.6, 0.9, 1.25, 3.0}) {
    const std::string setting =
        field.path + "=" + std::visit(OtherValue{factor, field.member.get()}, field.kind);
    try {
      (void)configuration(method, with(setting));
    } catch (const ConfigError&) {
      continue;
    }
    const Digests digests = digests_of(method, with(setting));
    if (!best || digests != plain) best = Tried{field.path, setting, digests, digests != plain};
    if (best->shows || is_named(field.path, shown_by_nothing)) break;
  }
  return best;
}

/// Every key within a table that may change so.
std::vector<Tried> every_change(const std::string& method, Changes when, const std::string& table = "") {
  EcuConfig config = configuration(method, eventful);
  Schema schema;
  describe(Section{schema}, config);
  const Digests plain = digests_of(method, eventful);
  std::vector<Tried> all;
  for (const Field& field : schema.fields) {
    const bool of_other =
        field.path.starts_with("control.") && field.path.find('.', 8) != std::string::npos &&
        !field.path.starts_with("control." + method) && !field.path.starts_with("control.machine_estimate");
    if (field.changes != when || of_other || !field.path.starts_with(table)) continue;
    if (const std::optional<Tried> one = tried(field, method, plain)) all.push_back(*one);
  }
  return all;
}

/// A drive that takes each key before its first period is, bit by bit, the drive that is started with it.
void expect_taken_as_started(const std::string& method, const std::vector<Tried>& all) {
  for (const Tried& one : all) {
    SCOPED_TRACE(one.setting);
    for (std::size_t k = 0; k < events.size(); ++k) {
      Running running{method, joined(eventful, events[k])};
      ASSERT_EQ(running.refusal({one.setting}), "offered");
      drive_through(running.loop);
      EXPECT_EQ(running.changes.outcome(), Outcome::taken);
      EXPECT_EQ(running.loop.digest(), one.digests[k]) << "event " << k;
    }
  }
}

TEST(ParameterChanges, ADriveThatHasTakenAKeyIsTheDriveThatIsStartedWithIt) {
  std::vector<Tried> all = every_change("foc", Changes::always);
  EXPECT_GT(all.size(), 45U) << "keys that may always change and can be tried alone";
  for (const Tried& one : all) {
    EXPECT_EQ(one.shows, !is_named(one.key, shown_by_nothing))
        << one.setting << ": what shows nothing cannot fail";
  }
  // A winding that is known stays as warm as it is; a new start has it at the ambient temperature.
  std::erase_if(all, [](const Tried& one) { return one.key == "protection.winding.ambient_c"; });
  expect_taken_as_started("foc", all);
}

TEST(ParameterChanges, TheSameHoldsOfTheKeysOfEachMethod) {
  for (const std::string& method : method_names()) {
    SCOPED_TRACE(method);
    expect_taken_as_started(method, every_change(method, Changes::always, "control."));
    const std::string limit = "drive.current_limit_a=60";
    expect_taken_as_started(method,
                            {{"drive.current_limit_a", limit, digests_of(method, with(limit)), true}});
  }
}

TEST(ParameterChanges, ADriveAtRestTakesEveryOtherKeyThatMayChange) {
  std::vector<Tried> all = every_change("foc", Changes::when_ready);
  std::erase_if(all, [](const Tried& one) { return one.setting == eventful.front(); });
  EXPECT_GT(all.size(), 15U);
  expect_taken_as_started("foc", all);
}

TEST(ParameterChanges, ALimitBelowThePresentCurrentTripsInTheNextPeriod) {
  Running running{"foc"};
  running.loop.run(to_torque, 100);
  ASSERT_EQ(running.loop.now().state, DriveState::torque);
  const ThreePhase<double>& i = running.loop.now().i_abc;
  const double peak = std::max({std::abs(i.a), std::abs(i.b), std::abs(i.c)});
  const double limit = 0.95 * peak;
  ASSERT_EQ(running.refusal({"protection.over_current_a=" + std::to_string(limit),
                             "drive.current_limit_a=" + std::to_string(0.99 * limit)}),
            "offered");
  EXPECT_EQ(running.changes.outcome(), Outcome::waits);
  running.loop.run(1, 100);
  EXPECT_EQ(running.changes.outcome(), Outcome::taken);
  EXPECT_EQ(running.loop.now().state, DriveState::fault);
  EXPECT_EQ(running.loop.now().first_fault, Fault::over_current);
}

TEST(ParameterChanges, ALowerTorqueLimitLowersWhatIsAvailableAtOnce) {
  Running running{"foc"};
  running.loop.run(to_torque, 40);
  ASSERT_EQ(running.refusal({"capability.torque_nm=25"}), "offered");
  running.loop.run(1, 40);
  EXPECT_EQ(running.loop.now().torque_reference, 25);
  running.loop.run(500, 40);
  EXPECT_NEAR(running.loop.now().torque, 25, 1);
  EXPECT_EQ(running.loop.now().state, DriveState::derated);
}

TEST(ParameterChanges, AFluxOptimumTakenUnderTorqueLeadsToTheFluxOfADriveStartedWithIt) {
  const Settings optimum{"drive.flux_optimum=min_loss"};
  Running running{"foc"};
  running.loop.run(to_torque, 10);
  const double whole = running.loop.now().psi_s_magnitude;
  ASSERT_EQ(running.refusal(optimum), "offered");
  running.loop.run(6 * to_torque, 10);
  Loop started{configuration("foc", optimum)};
  started.run(7 * to_torque, 10);
  EXPECT_LT(started.now().psi_s_magnitude, 0.9 * whole);
  EXPECT_NEAR(running.loop.now().psi_s_magnitude, started.now().psi_s_magnitude, 1e-3 * whole);
}

TEST(ParameterChanges, ADerivedValueChangesWithWhatItFollowsFrom) {
  Running running{"foc"};
  const double before = running.changes.config().drive.drive.motor.capability.current_limit;
  ASSERT_EQ(running.refusal({"protection.over_current_a=200"}), "offered");
  running.loop.run(1, {});
  ASSERT_EQ(running.changes.outcome(), Outcome::taken);
  EXPECT_NE(before, 160);
  EXPECT_DOUBLE_EQ(running.changes.config().drive.drive.motor.capability.current_limit, 160)
      << "0.8 of the trip";
  EXPECT_EQ(running.refusal({"protection.over_current_a=200"}), "unchanged");
}

TEST(ParameterChanges, WhatNeedsRestIsRefusedUnderTorqueAndWhileThereIsFlux) {
  const Settings flux{"control.flux_reference_wb=0.9"};
  Running running{"foc"};
  running.loop.run(to_torque, 40);
  ASSERT_EQ(running.refusal(flux), "offered");
  running.loop.run(1, 40);
  EXPECT_EQ(running.changes.outcome(), Outcome::refused);
  EXPECT_EQ(not_at_rest(running.changes.changes()).substr(0, 46),
            "control.flux_reference_wb changes only with th");
  running.loop.run(50, {});
  ASSERT_EQ(running.loop.now().state, DriveState::ready);
  ASSERT_EQ(running.refusal(flux), "offered");
  running.loop.run(1, {});
  EXPECT_EQ(running.changes.outcome(), Outcome::refused) << "gates off, and the flux has not decayed";
  running.loop.run(20'000, {});
  ASSERT_EQ(running.refusal(flux), "offered");
  running.loop.run(1, {});
  EXPECT_EQ(running.changes.outcome(), Outcome::taken);
  EXPECT_EQ(running.loop.now().state, DriveState::ready);
  running.loop.run(to_torque, 40);
  EXPECT_EQ(running.loop.now().state, DriveState::torque);
  EXPECT_NEAR(running.loop.now().psi_s_magnitude, 0.9, 0.01);
  EXPECT_NEAR(running.loop.now().torque, 40, 1);
  ASSERT_EQ(running.refusal({"control.foc.bandwidth_rad_s=1000"}), "offered") << "of the drive that runs now";
  running.loop.run(1, 40);
  EXPECT_EQ(running.changes.outcome(), Outcome::taken);
}

TEST(ParameterChanges, RefusalsAreSentences) {
  Running running{"foc"};
  const auto says = [&running](const std::string& setting, const std::string& part) {
    const std::string sentence = running.refusal({setting});
    EXPECT_NE(sentence.find(part), std::string::npos) << sentence;
  };
  says("plant.u_dc_v=500", "plant.u_dc_v never changes while the drive runs: start it anew with --set");
  says("drive.period_us=50", "never changes while the drive runs");
  says("control.controller=dtc", "control.controller never changes while the drive runs");
  says("machine.r_s_ohm=0.3", "never changes while the drive runs");
  says("can.identifier_offset=32", "can.identifier_offset never changes");
  says("protection.over_curent_a=100", "the nearest known one is protection.over_current_a");
  says("protection.over_current_a=-1", "expected a number from 0.1 to 100000");
  says("drive.current_limit_a=1e4", "current_limit_a must be below protection.over_current_a");
  running.loop.run(1, {});
  EXPECT_EQ(running.loop.shared().parameter_sets.load(), 0U);
}

TEST(ParameterChanges, AFileThatHasBecomeAnotherIsNotTakenOn) {
  Loop loop{configuration("foc")};
  ParameterChanges changes{configuration("foc"),
                           [](Settings more) {
                             more.insert(more.begin(), "protection.over_speed_rad_s=100");
                             return configuration("foc", more);
                           },
                           loop.shared()};
  try {
    (void)changes.offer({"command.torque_limit_nm=50"});
    FAIL() << "accepted";
  } catch (const std::runtime_error& problem) {
    EXPECT_NE(std::string{problem.what()}.find("protection.over_speed_rad_s from"), std::string::npos);
  }
}

}  // namespace
}  // namespace sextant::ecu
