// Each rule finds the controller that breaks it, and no other rule does.
#include "sextant/conformance/check_controller.hpp"

#include <array>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/control/field_oriented_controller.hpp"

namespace sextant {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::StartsWith;

enum class Mistake {
  none,
  short_pattern,
  short_when_off,
  negative,
  driven_when_off,
  nan,
  forgets_a_state,
  forgets_magnetised,
  too_many_channels
};

/// Half of the period at V1, half at V0; with one mistake, which shows rarely.
class MistakenController final : public Controller<double> {
 public:
  static constexpr std::array channels{ControlChannel{"speed_rad_s", "rad/s", "as measured"}};
  struct Parameters {
    Mistake mistake{Mistake::none};
  };

  explicit MistakenController(const Parameters& parameters) noexcept : mistake_{parameters.mistake} {}

  GatePattern step(const Measurement<double>& m, ControlReference<double> reference) noexcept override {
    ++count_;
    values_ = {m.omega_m, 0.0};
    const bool now = count_ % 1000 == 999;
    estimate_.torque =
        mistake_ == Mistake::nan && now ? std::numeric_limits<double>::quiet_NaN() : reference.torque;
    // Counted in a state that a reset leaves as it is.
    estimate_.magnetised = mistake_ == Mistake::forgets_magnetised && ++lifetime_ > 7'000;
    if (reference.mode == ControlMode::off && mistake_ == Mistake::short_when_off) return {gates_off, 24'999};
    if (reference.mode == ControlMode::off)
      return mistake_ == Mistake::driven_when_off ? GatePattern{switch_states[0], 25'000} : GatePattern{};
    GatePattern pattern;
    if (mistake_ == Mistake::negative && now) {
      pattern.append({switch_states[1], 26'000});
      pattern.append({switch_states[0], -1'000});
      return pattern;
    }
    pattern.append({switch_states[1], count_ % 3 == 0 ? 0 : 10'000});
    pattern.append({switch_states[0], count_ % 3 == 0 ? 25'000 : 15'000});
    if (mistake_ == Mistake::short_pattern && now) return {switch_states[0], 24'999};
    return pattern;
  }

  void reset() noexcept override {
    estimate_ = {};
    if (mistake_ != Mistake::forgets_a_state) count_ = 0;
  }

  [[nodiscard]] std::span<const double> channel_values() const noexcept override {
    return std::span{values_}.first(mistake_ == Mistake::too_many_channels ? 2U : 1U);
  }

 private:
  Mistake mistake_;
  int count_{0};
  int lifetime_{0};
  std::array<double, 2> values_{};
};

std::vector<std::string> violations(Mistake mistake) {
  return check_controller<MistakenController>({mistake}, {.has_flux_reference = false}).violations;
}

TEST(CheckController, NamesTheRuleThatIsBroken) {
  EXPECT_THAT(violations(Mistake::short_pattern), ElementsAre(StartsWith("period: ")));
  EXPECT_THAT(violations(Mistake::short_when_off), ElementsAre(StartsWith("period: ")));
  EXPECT_THAT(violations(Mistake::negative), ElementsAre(StartsWith("durations: ")));
  EXPECT_THAT(violations(Mistake::driven_when_off), ElementsAre(StartsWith("off: ")));
  EXPECT_THAT(violations(Mistake::nan), ElementsAre(StartsWith("finite: ")));
  EXPECT_THAT(violations(Mistake::forgets_a_state), ElementsAre(StartsWith("reset: ")));
  EXPECT_THAT(violations(Mistake::forgets_magnetised), ElementsAre(StartsWith("reset: ")));
  EXPECT_THAT(violations(Mistake::too_many_channels), ElementsAre(StartsWith("channels: ")));
}

/// A controller of Sextant that gets another share of the flux than the one that is asked for.
template <class C, double (*share_of)(double)>
class Misled final : public Controller<double> {
 public:
  using Parameters = typename C::Parameters;
  explicit Misled(const Parameters& parameters) : inner_{parameters} {}
  GatePattern step(const Measurement<double>& m, ControlReference<double> reference) noexcept override {
    reference.flux_share = share_of(reference.flux_share);
    const GatePattern pattern = inner_.step(m, reference);
    estimate_ = inner_.estimate();
    return pattern;
  }
  void reset() noexcept override {
    inner_.reset();
    estimate_ = inner_.estimate();
  }

 private:
  C inner_;
};

constexpr double whole(double /*share*/) {
  return 1.0;
}
constexpr double square(double share) {
  return share * share;
}
constexpr double root(double share) {
  return share < 1.0 ? 0.7 : 1.0;
}

template <template <class, double (*)(double)> class M, class C>
void expect_that_the_flux_is_missed() {
  const auto found = [](auto result) { return result.violations; };
  const ConformanceParameters p{.periods = 100};
  EXPECT_THAT(found(check_controller<M<C, whole>>({}, p)), ElementsAre(StartsWith("flux: "))) << C::name;
  EXPECT_THAT(found(check_controller<M<C, square>>({}, p)), ElementsAre(StartsWith("flux: "))) << C::name;
  EXPECT_THAT(found(check_controller<M<C, root>>({}, p)), ElementsAre(StartsWith("flux: "))) << C::name;
}

TEST(CheckController, AFluxThatIsNotTheShareIsFound) {
  expect_that_the_flux_is_missed<Misled, DirectTorqueController<double>>();
  expect_that_the_flux_is_missed<Misled, FieldOrientedController<double>>();
}

TEST(CheckController, FindsNothingInAControllerThatConforms) {
  EXPECT_THAT(violations(Mistake::none), IsEmpty());
}

TEST(CheckController, SaysTheSeed) {
  ConformanceParameters p{.seed = 987654321, .has_flux_reference = false};
  const ConformanceResult result = check_controller<MistakenController>({Mistake::nan}, p);
  EXPECT_EQ(result.seed, 987654321U);
  EXPECT_THAT(result.violations, ElementsAre(testing::HasSubstr("of seed 987654321")));
}

}  // namespace
}  // namespace sextant
