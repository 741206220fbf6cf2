// What is said of structs of parameters: each member has a name of its own, by which it alone is set.

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/config/ecu_config.hpp"
#include "sextant/control/controller_list.hpp"
#include "sextant/core/inverter_model.hpp"
#include "sextant/core/minimum_pulse.hpp"
#include "sextant/core/saturation_parameters.hpp"
#include "sextant/core/winding_resistance.hpp"
#include "sextant/drive/anti_jerk.hpp"
#include "sextant/drive/capability_setup.hpp"
#include "sextant/drive/command_setup.hpp"
#include "sextant/drive/optimal_flux.hpp"
#include "sextant/drive/protection_setup.hpp"
#include "sextant/drive/torque_monitor_setup.hpp"
#include "sextant/event_exact/event_exact_parameters.hpp"
#include "sextant/hil/hil_parameters.hpp"
#include "sextant/plant/conduction_drops.hpp"
#include "sextant/plant/cvode_parameters.hpp"
#include "sextant/plant/dc_link_parameters.hpp"
#include "sextant/plant/driveline_parameters.hpp"
#include "sextant/plant/exact_integrator.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"
#include "sextant/plant/initial_state.hpp"
#include "sextant/plant/inverter_loss_parameters.hpp"
#include "sextant/plant/iron_loss_parameters.hpp"
#include "sextant/plant/leakage_saturation.hpp"
#include "sextant/plant/magnetising_points.hpp"
#include "sextant/plant/thermal_parameters.hpp"
#include "sextant/plant/vehicle_parameters.hpp"
#include "sextant/power_stage/encoder.hpp"
#include "sextant/power_stage/plant_fault.hpp"
#include "sextant/power_stage/resolver.hpp"
#include "sextant/power_stage/sensor_model.hpp"
#include "sextant/power_stage/sin_cos_encoder.hpp"
#include "sextant/realtime/realtime_parameters.hpp"

namespace sextant {
namespace {

/// Keeps what is described.
class Described final : public Description {
 public:
  struct Entry {
    std::string name;
    std::string meaning;
    std::function<double()> get;
    std::function<void(double)> set;
    double min;
    double max;
  };

  void number(const char* name, NumberMember x, const Quantity& q) override {
    add(
        name, q, [x] { return x.get().value_or(std::numeric_limits<double>::infinity()); },
        [x](double value) { x.set(value); });
  }
  void derived(const char* name, NumberMember given, NumberValue /*value*/, const Quantity& q) override {
    number(name, given, q);
  }
  void defaulted(const char* name, NumberMember x, NumberDefault /*by_default*/, const Quantity& q,
                 const char* /*otherwise*/) override {
    number(name, x, q);
  }
  void points(const char* name, PointsMember x, const Axis& /*first*/, const Axis& /*second*/,
              const char* unit, const char* meaning) override {
    add(
        name, {unit, 0, 1, meaning}, [x] { return double(x.size()); },
        [x](double size) {
          const std::array<PointsMember::Point, 1> points{{{1, 2}}};
          x.set(std::span{points}.first(std::size_t(size)));
        });
  }
  void text(const char* name, TextMember x, const char* meaning, bool /*may_be_empty*/) override {
    add(
        name, {"", 0, 1, meaning}, [x] { return x.get() == "another" ? 1.0 : 0.0; },
        [x](double value) { x.set(value > 0.5 ? "another" : "one"); });
  }
  void integer(const char* name, IntegerMember x, const char* unit, std::int64_t min, std::int64_t max,
               const char* meaning, Changes /*changes*/) override {
    add(
        name, {unit, double(min), double(max), meaning}, [x] { return double(x.get()); },
        [x](double value) { x.set(std::int64_t(value)); });
  }
  void flag(const char* name, bool& x, const char* meaning, Changes /*changes*/) override {
    add(name, {"", 0, 1, meaning}, [&x] { return double(x); }, [&x](double value) { x = value > 0.5; });
  }
  void choice(const char* name, IntegerMember x, std::span<const Choice<std::int64_t>> choices,
              const char* meaning, Changes changes) override {
    const auto by_value = [](const auto& a, const auto& b) { return a.value < b.value; };
    const auto [least, most] = std::minmax_element(choices.begin(), choices.end(), by_value);
    integer(name, x, "", least->value, most->value, meaning, changes);
  }
  void enter(const char* table) override { tables_.emplace_back(table); }
  void leave() override { tables_.pop_back(); }

  std::vector<Entry> entries{};

 private:
  void add(const char* name, const Quantity& q, std::function<double()> get,
           std::function<void(double)> set) {
    std::string path;
    for (const std::string& table : tables_) path += table + ".";
    entries.push_back({path + name, q.meaning, std::move(get), std::move(set), q.min, q.max});
  }

  std::vector<std::string> tables_{};
};

/// Stands for a member of any type.
struct Anything {
  template <class T>
  constexpr operator T() const {  // NOLINT(google-explicit-constructor): stands for the member
    return T{};
  }
};

/// Members of an aggregate, by the most values that its initialiser takes.
template <class S, class... Values>
consteval std::size_t members() {
  if constexpr (requires { S{Values{}..., Anything{}}; }) {
    return members<S, Values..., Anything>();
  } else {
    return sizeof...(Values);
  }
}

struct OfThree {
  double a{};
  std::int64_t b{};
  std::optional<float> c{};
};
static_assert(members<OfThree>() == 3);

/// Every entry has words and a range, and sets itself alone.
void expect_own_members(const Described& described, std::size_t count) {
  EXPECT_EQ(described.entries.size(), count)
      << "a member that is bound and not described, or described twice";
  std::set<std::string> names;
  for (const Described::Entry& entry : described.entries) {
    SCOPED_TRACE(entry.name);
    EXPECT_TRUE(names.insert(entry.name).second);
    EXPECT_FALSE(entry.meaning.empty());
    EXPECT_LT(entry.min, entry.max);
    std::vector<double> before;
    before.reserve(described.entries.size());
    for (const Described::Entry& other : described.entries) before.push_back(other.get());
    entry.set(entry.get() == entry.max ? entry.min : entry.max);
    for (std::size_t k = 0; k < before.size(); ++k) {
      const Described::Entry& other = described.entries[k];
      EXPECT_EQ(other.get() != before[k], &other == &entry) << other.name;
    }
  }
}

template <class T>
class Descriptions : public ::testing::Test {};
using Scalars = ::testing::Types<double, float>;
TYPED_TEST_SUITE(Descriptions, Scalars);

TYPED_TEST(Descriptions, NameEveryMemberOfCommandSetup) {
  CommandSetup<TypeParam> setup;
  Described d;
  describe(d, setup, CommandLimits<TypeParam>{});
  expect_own_members(d, members<CommandSetup<TypeParam>>());
}

TYPED_TEST(Descriptions, NameEveryMemberOfCapabilitySetup) {
  CapabilitySetup<TypeParam> setup;
  Described d;
  describe(d, setup, typename TorqueCapability<TypeParam>::Parameters{});
  expect_own_members(d, members<CapabilitySetup<TypeParam>>());
}

TYPED_TEST(Descriptions, NameEveryMemberOfProtectionSetup) {
  ProtectionSetup<TypeParam> setup;
  Described d;
  describe(d, setup, ProtectionLimits<TypeParam>{});
  const std::size_t winding = members<typename WindingTemperature<TypeParam>::Parameters>();
  expect_own_members(d, members<ProtectionSetup<TypeParam>>() - 1 + winding);
  const auto in_its_table = [](const Described::Entry& e) { return e.name.starts_with("winding."); };
  EXPECT_EQ(std::count_if(d.entries.begin(), d.entries.end(), in_its_table), 2 + std::ptrdiff_t(winding));
}

TYPED_TEST(Descriptions, NameEveryMemberOfTorqueMonitorSetupButItsMachine) {
  TorqueMonitorSetup<TypeParam> setup;
  Described d;
  describe(d, setup, TorqueMonitorLimits<TypeParam>{});
  expect_own_members(d, members<TorqueMonitorSetup<TypeParam>>() - 1);
}

TYPED_TEST(Descriptions, NameEveryMemberOfTheInvertersParameters) {
  using Parameters = typename InverterModel<TypeParam>::Parameters;
  Parameters p;
  std::optional<TypeParam> voltage_error;
  Described d;
  describe(d, p, voltage_error, Parameters{});
  expect_own_members(d, members<Parameters>() - 1 + members<MinimumPulse::Parameters>());
  EXPECT_EQ(p.voltage_error, TypeParam(0)) << "what a user states of it is elsewhere";
}

template <class... C>
std::tuple<std::type_identity<C>...> of_types(const std::tuple<C...>* /*list*/) {
  return {};
}

/// Of a struct of numbers that have a default each.
template <class Parameters>
void expect_all_named_with_defaults(std::size_t left_out = 0) {
  Parameters p;
  const Parameters by_default;
  Described d;
  describe(d, p, by_default);
  expect_own_members(d, members<Parameters>() - left_out);
}

/// Of a struct with nothing that follows from others.
template <class Parameters>
void expect_all_named() {
  Parameters p;
  Described d;
  describe(d, p);
  expect_own_members(d, members<Parameters>());
}

TYPED_TEST(Descriptions, NameEveryMemberOfTheRestOfTheDrive) {
  expect_all_named<typename OptimalFlux<TypeParam>::Parameters>();
  expect_all_named<AntiJerkParameters<TypeParam>>();
  expect_all_named<typename WindingTemperature<TypeParam>::Parameters>();
  expect_all_named<WindingResistance<TypeParam>>();
}

TYPED_TEST(Descriptions, NameEveryMemberOfThePartsOfControllers) {
  expect_all_named_with_defaults<typename Magnetiser<TypeParam>::Parameters>();
  expect_all_named_with_defaults<typename TorqueComparator<TypeParam>::Parameters>();
  expect_all_named_with_defaults<typename FluxComparator<TypeParam>::Parameters>();
  expect_all_named_with_defaults<typename TorqueTrim<TypeParam>::Parameters>();
  expect_all_named<typename TorqueTrim<TypeParam>::Parameters>();
  expect_all_named<typename SectorSelector<TypeParam>::Parameters>();
  typename SpaceVectorModulator<TypeParam>::Parameters modulator;
  Described d;
  describe(d, modulator);
  expect_own_members(d, members<decltype(modulator)>() - 1);
}

TYPED_TEST(Descriptions, OfControllersHaveTheKeysOfTheirParts) {
  std::apply(
      [](auto... controllers) {
        const auto expect_own = []<class C>(std::type_identity<C>) {
          typename C::Parameters p;
          const typename C::Parameters by_default;
          Described d;
          describe(d, p, by_default);
          expect_own_members(d, d.entries.size());
          EXPECT_GE(d.entries.size(), 3U) << C::name << ": two keys of magnetising, and its own";
        };
        (expect_own(controllers), ...);
      },
      of_types(static_cast<ControllerList<TypeParam>*>(nullptr)));
}

TYPED_TEST(Descriptions, NameEveryMemberOfThePlant) {
  expect_all_named<ConductionDrops<TypeParam>>();
  expect_all_named<SaturationParameters<TypeParam>>();
  expect_all_named<MagnetisingPoints<TypeParam>>();
  expect_all_named<LeakageSaturation<TypeParam>>();
  expect_all_named<IronLossParameters<TypeParam>>();
  expect_all_named<DcLinkParameters<TypeParam>>();
  expect_all_named<DrivelineParameters<TypeParam>>();
  expect_all_named<InitialState<TypeParam>>();
  ThermalParameters<TypeParam> thermal;
  Described of_thermal;
  describe(of_thermal, thermal);
  const std::size_t in_nodes = 3 * (members<ThermalNodes<TypeParam>>() - 1);
  expect_own_members(of_thermal, members<ThermalParameters<TypeParam>>() + in_nodes);
}

TEST(DescriptionsOfARun, NameEveryMember) {
  expect_all_named<MinimumPulse::Parameters>();
  expect_all_named<ErrorControl>();
  expect_all_named<EventExactParameters>();
  expect_all_named<WaitParameters>();
  expect_all_named<EncoderParameters>();
  expect_all_named<ResolverParameters>();
  expect_all_named<SinCosEncoderParameters>();
  expect_all_named<TemperatureSensorParameters>();
  expect_all_named<VehicleParameters>();
  expect_all_named<FixedStepParameters>();
  expect_all_named<ExactParameters>();
  expect_all_named<HilParameters>();
  expect_all_named<DdsConfig>();
  expect_all_named<CanConfig>();
  CvodeParameters cvode;
  Described of_cvode;
  describe(of_cvode, cvode);
  expect_own_members(of_cvode, members<ErrorControl>() + members<CvodeParameters>() - 1);
  RealtimeParameters realtime;
  Described of_realtime;
  describe(of_realtime, realtime);
  expect_own_members(of_realtime, members<RealtimeParameters>() - 1 + members<WaitParameters>());
}

TEST(DescriptionsOfARun, NameEveryMemberOfSensorsFaultsAndLosses) {
  SensorParameters sensors;
  const std::int32_t lead_of_drive = 0;
  Described of_sensors;
  describe(of_sensors, sensors, lead_of_drive);
  const std::size_t in_parts = 2 * members<ConverterParameters>() + 3 * members<PhaseSensorError>() +
                               members<EncoderParameters>() + members<ResolverParameters>() +
                               members<SinCosEncoderParameters>() + members<TemperatureSensorParameters>();
  expect_own_members(of_sensors, in_parts + 3);  // and seed, lead and skew
  PlantFaultParameters fault;
  const double u_dc = 530;
  Described of_fault;
  describe(of_fault, fault, u_dc);
  expect_own_members(of_fault, members<PlantFaultParameters>());
  InverterLossParameters losses;
  Described of_losses;
  describe(of_losses, losses);
  expect_own_members(of_losses, members<InverterLossParameters>() + 5);  // five tables of two curves
}

TEST(DefaultOfANumber, IsTheShareOfTheOtherOneWhenItIsSet) {
  double x = 1;
  double other = 3;
  const NumberDefault half{x, other, 0.5};
  other = 8;
  half.set();
  EXPECT_EQ(x, 4);
  const double odd = 0.1 + 0.2;
  NumberDefault{x, odd}.set();
  EXPECT_EQ(x, odd) << "bit by bit";
}

TEST(PointsOfAMember, AreInTheUnitOfTheKey) {
  std::vector<std::pair<double, double>> list{{1, 0.002}};
  const PointsMember member{list, 1e-3};
  EXPECT_EQ(member.get(0), (PointsMember::Point{1, 2}));
  const std::array<PointsMember::Point, 2> given{{{3, 4}, {5, 6}}};
  member.set(given);
  EXPECT_EQ(list, (std::vector<std::pair<double, double>>{{3, 4 * 1e-3}, {5, 6 * 1e-3}}));
}

}  // namespace
}  // namespace sextant
