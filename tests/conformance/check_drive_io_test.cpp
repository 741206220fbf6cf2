// Each rule finds the power stage that breaks it.
#include "sextant/conformance/check_drive_io.hpp"

#include <limits>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sextant/core/two_level_inverter.hpp"

namespace sextant {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::StartsWith;

constexpr std::int32_t period_ns = 100'000;

enum class Mistake {
  none,
  never_plausible,
  implausible_once,
  nan_speed,
  infinite_temperature,
  angle_of_a_full_turn,
  one_period_after_missed_ones,
  short_by_a_tick,
  negative_segment,
  last_written,
  only_the_last_state,
  mirrored_order,
  empty_keeps_the_gates,
  off_is_low,
  holds_for_ever,
  swapped_sensors,
  inverted_sensors,
  one_sensor_of_twice_the_gain
};

/// An inverter with a leakage inductance of 5 mH at 500 V, ideal but for one mistake. Gates that are off let
/// no current remain. A pattern lasts for a period.
template <class T>
class MistakenDriveIo final : public DriveIo<T> {
 public:
  explicit MistakenDriveIo(Mistake mistake, int delay = 0) noexcept : mistake_{mistake}, delay_{delay} {}

  [[nodiscard]] Measurement<T> read(std::int64_t t_ns) noexcept override {
    ++reads_;
    const std::int64_t elapsed_ns = reads_ == 1 ? 0 : t_ns - t_ns_;
    t_ns_ = t_ns;
    const GatePattern acted = acting(elapsed_ns);
    if (acted.is_driven())
      i_s_ += T(1 / 5e-3) * volt_seconds(acted, T(500));
    else
      i_s_ = {};
    return measured(acted);
  }

  void write(const GatePattern& pattern) noexcept override {
    const bool keeps = mistake_ == Mistake::empty_keeps_the_gates && pattern.segments().empty();
    GatePattern taken = keeps ? written_ : pattern;
    if (mistake_ == Mistake::off_is_low && !pattern.is_driven()) taken = {switch_states[0], period_ns};
    active_ = delay_ == 0 ? taken : written_;
    written_ = taken;
    is_renewed_ = true;
  }

 private:
  /// The active pattern, and without another one the gates off.
  [[nodiscard]] GatePattern acting(std::int64_t elapsed_ns) noexcept {
    const bool holds = mistake_ == Mistake::holds_for_ever && active_.is_driven();
    const bool acts = std::exchange(is_renewed_, false) && active_.duration_ns() > 0;
    if (holds && !acts) return {active_.last_state(), std::int32_t(elapsed_ns)};
    GatePattern acted = acts ? active_ : GatePattern{};
    const std::int64_t rest_ns = elapsed_ns - acted.duration_ns();
    acted.append({holds ? active_.last_state() : gates_off, std::int32_t(rest_ns)});
    return acted;
  }

  [[nodiscard]] Measurement<T> measured(const GatePattern& acted) const noexcept {
    const bool now = reads_ == 40;
    Measurement<T> m{.i_abc = sensed(inverse_clarke(i_s_)), .u_dc = T(500), .applied = told(acted)};
    m.theta_m = mistake_ == Mistake::angle_of_a_full_turn ? T(6.2) : T(-3.1);
    m.plausible = mistake_ != Mistake::never_plausible && !(mistake_ == Mistake::implausible_once && now);
    if (mistake_ == Mistake::nan_speed && now) m.omega_m = std::numeric_limits<T>::quiet_NaN();
    if (mistake_ == Mistake::infinite_temperature && now)
      m.winding_temperature = std::numeric_limits<T>::infinity();
    return m;
  }

  [[nodiscard]] ThreePhase<T> sensed(ThreePhase<T> i) const noexcept {
    if (mistake_ == Mistake::swapped_sensors) return {i.a, i.c, i.b};
    if (mistake_ == Mistake::inverted_sensors) return {-i.a, -i.b, -i.c};
    if (mistake_ == Mistake::one_sensor_of_twice_the_gain) return {i.a, T(2) * i.b, i.c};
    return i;
  }

  /// What is reported of what has acted.
  [[nodiscard]] GatePattern told(const GatePattern& acted) const noexcept {
    const std::span<const GateSegment> segments = acted.segments();
    const bool several = segments.size() > 2;
    if (mistake_ == Mistake::one_period_after_missed_ones && acted.duration_ns() > period_ns)
      return {gates_off, period_ns};
    if (mistake_ == Mistake::short_by_a_tick && acted.duration_ns() == period_ns && segments.size() == 1)
      return {acted.last_state(), period_ns - 10};
    if (mistake_ == Mistake::last_written && acted.is_driven()) return written_;
    if (mistake_ == Mistake::only_the_last_state && several)
      return {acted.last_state(), std::int32_t(acted.duration_ns())};
    GatePattern pattern;
    if (mistake_ == Mistake::negative_segment && several) {
      pattern.append({acted.last_state(), period_ns + 10});
      pattern.append({gates_off, -10});
      return pattern;
    }
    if (mistake_ != Mistake::mirrored_order || !several) return acted;
    for (std::size_t k = segments.size(); k-- > 0;) pattern.append(segments[k]);
    return pattern;
  }

  Mistake mistake_;
  int delay_;
  int reads_{0};
  bool is_renewed_{false};
  std::int64_t t_ns_{};
  SpaceVector<T> i_s_{};  ///< [A]
  GatePattern written_{};
  GatePattern active_{};
};

std::vector<std::string> violations(Mistake mistake, DriveIoConformanceParameters p = {}) {
  MistakenDriveIo<double> io{mistake};
  p.period_ns = period_ns;
  return check_drive_io(io, p).violations;
}

TEST(CheckDriveIo, FindsNothingInAPowerStageThatConforms) {
  EXPECT_THAT(violations(Mistake::none), IsEmpty());
  for (const int delay : {0, 1}) {
    MistakenDriveIo<float> io{Mistake::none, delay};
    EXPECT_THAT(check_drive_io(io, {.period_ns = period_ns, .actuation_delay_periods = delay}).violations,
                IsEmpty());
  }
}

TEST(CheckDriveIo, NamesTheRuleThatIsBroken) {
  EXPECT_THAT(violations(Mistake::never_plausible), ElementsAre(StartsWith("plausible: ")));
  EXPECT_THAT(violations(Mistake::implausible_once), ElementsAre(StartsWith("plausible: ")));
  EXPECT_THAT(violations(Mistake::nan_speed), ElementsAre(StartsWith("finite: ")));
  EXPECT_THAT(violations(Mistake::infinite_temperature), ElementsAre(StartsWith("finite: ")));
  EXPECT_THAT(violations(Mistake::angle_of_a_full_turn), ElementsAre(StartsWith("finite: ")));
  EXPECT_THAT(violations(Mistake::one_period_after_missed_ones), ElementsAre(StartsWith("duration: ")));
  EXPECT_THAT(violations(Mistake::only_the_last_state), ElementsAre(StartsWith("applied: ")));
  EXPECT_THAT(violations(Mistake::mirrored_order), ElementsAre(StartsWith("applied: ")));
  EXPECT_THAT(violations(Mistake::empty_keeps_the_gates), ElementsAre(StartsWith("off: ")));
  EXPECT_THAT(violations(Mistake::holds_for_ever), ElementsAre(StartsWith("silence: ")));
  EXPECT_THAT(violations(Mistake::swapped_sensors), ElementsAre(StartsWith("currents: V5 ")));
  EXPECT_THAT(violations(Mistake::inverted_sensors), ElementsAre(StartsWith("currents: V1 ")));
  EXPECT_THAT(violations(Mistake::one_sensor_of_twice_the_gain), ElementsAre(StartsWith("currents: ")));
}

// Mistakes that break other rules too.
TEST(CheckDriveIo, NamesEachRuleThatIsBroken) {
  EXPECT_THAT(violations(Mistake::negative_segment), Contains(StartsWith("duration: a segment")));
  EXPECT_THAT(violations(Mistake::short_by_a_tick), Contains(StartsWith("duration: ")));
  EXPECT_THAT(violations(Mistake::off_is_low), Contains(StartsWith("off: ")));
  for (const int delay : {0, 1}) {
    MistakenDriveIo<double> io{Mistake::none, 1 - delay};
    EXPECT_THAT(check_drive_io(io, {.period_ns = period_ns, .actuation_delay_periods = delay}).violations,
                Contains(StartsWith("applied: ")))
        << "a delay of " << 1 - delay << " where " << delay << " is said";
  }
  MistakenDriveIo<double> io{Mistake::last_written, 1};
  EXPECT_THAT(check_drive_io(io, {.period_ns = period_ns, .actuation_delay_periods = 1}).violations,
              Contains(StartsWith("applied: ")));
}

TEST(CheckDriveIo, WithoutAMachineOrWithCoarserEdgesTheRuleIsWeaker) {
  EXPECT_THAT(violations(Mistake::inverted_sensors, {.has_machine = false}), IsEmpty());
  EXPECT_THAT(violations(Mistake::short_by_a_tick, {.resolution_ns = 10}), IsEmpty());
}

TEST(CheckDriveIo, SaysWhenAndHowMuch) {
  EXPECT_THAT(violations(Mistake::one_period_after_missed_ones).front(),
              testing::HasSubstr("100000 ns where 300000 ns have passed"));
  EXPECT_THAT(violations(Mistake::nan_speed), ElementsAre(testing::HasSubstr("first 40 periods after")));
}

}  // namespace
}  // namespace sextant
