// What magnetising does with every control method, closed around the reference machine.
#include "sextant/control/magnetising_control.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <tuple>

#include <gtest/gtest.h>

#include "control/reference_machine.hpp"
#include "sextant/control/controller_list.hpp"

namespace sextant {
namespace {

/// An imposed speed that rises linearly.
struct Shaft {
  double omega_m;  ///< at the beginning [rad/s]
  double slope;    ///< [rad/s²]
};

/// What a magnetising of half a second shows.
struct Magnetising {
  double mean_torque{};   ///< largest magnitude of the mean over 20 ms [N·m]
  double peak_current{};  ///< [A]
  double psi_s{};         ///< at the end [Wb]
};

constexpr double current_limit = 25;

template <class C>
Magnetising magnetise(std::int32_t period_ns, const Shaft& shaft) {
  typename C::Parameters p;
  p.period_ns = period_ns;
  p.magnetiser = {.current_limit = current_limit, .hand_over_current = 16};
  C controller{p};
  test::ReferenceMachine machine;
  GatePattern applied{gates_off, period_ns};
  Magnetising seen;
  double impulse = 0;  // of the present period [N·m·s]
  machine.on_part = [&](double dt) {
    impulse += machine.torque() * dt;
    seen.peak_current = std::max(seen.peak_current, std::abs(machine.i_s()));
  };
  const std::size_t span = 20'000'000U / static_cast<std::size_t>(period_ns);
  std::deque<double> impulses;
  double sum = 0;
  for (std::int64_t t_ns = 0; t_ns < 500'000'000; t_ns += period_ns) {
    machine.omega_m = shaft.omega_m + shaft.slope * double(t_ns) * 1e-9;
    applied = controller.step(machine.template measure<double>(applied), {ControlMode::magnetise, 0, 1});
    impulse = 0;
    machine.apply(applied);
    impulses.push_back(impulse);
    sum += impulse;
    if (impulses.size() <= span) continue;
    sum -= impulses.front();
    impulses.pop_front();
    seen.mean_torque = std::max(seen.mean_torque, std::abs(sum) / 0.02);
  }
  seen.psi_s = std::abs(machine.psi_s);
  return seen;
}

template <class C>
class MagnetisingOf : public testing::Test {};
template <class List>
struct TypesOf;
template <class... C>
struct TypesOf<std::tuple<C...>> {
  using Type = testing::Types<C...>;
};
TYPED_TEST_SUITE(MagnetisingOf, TypesOf<ControllerList<double>>::Type);

// A vector for 125 µs changes the torque by 31 N·m: half of it where it stays for 20 ms. 150 N·m is the limit
// of the drive's torque.
TYPED_TEST(MagnetisingOf, MakesNoTorqueAtAnySpeedAndThroughStandstill) {
  for (const std::int32_t period_ns : {50'000, 125'000, 250'000}) {
    for (const Shaft& shaft : {Shaft{0.3, 0}, Shaft{-1, 4}, Shaft{4, -16}, Shaft{-60, 300}, Shaft{-100, 0}}) {
      SCOPED_TRACE(std::to_string(period_ns) + " ns, " + std::to_string(shaft.omega_m) + " rad/s, " +
                   std::to_string(shaft.slope) + " rad/s²");
      const Magnetising seen = magnetise<TypeParam>(period_ns, shaft);
      EXPECT_LE(seen.mean_torque, 150.0 / 75);
      EXPECT_LE(seen.peak_current, 1.15 * current_limit);
      EXPECT_NEAR(seen.psi_s, 1.1, 0.03);
    }
  }
}

}  // namespace
}  // namespace sextant
