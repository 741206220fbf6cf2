#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sextant/conformance/conformance_parameters.hpp"
#include "sextant/conformance/conformance_result.hpp"
#include "sextant/conformance/flux_loop.hpp"
#include "sextant/conformance/random_periods.hpp"
#include "sextant/control/controller.hpp"
#include "sextant/core/gate_pattern.hpp"

namespace sextant {

/// Runs controllers on seeded random inputs, and on a machine, and checks what a drive relies on:
///
///   period      the pattern fills the control period exactly; in mode off it may be empty instead
///   durations   no segment has a negative duration
///   off         in mode off every leg is off
///   finite      estimate and channels are finite for finite inputs
///   channels    as many values as channels are declared
///   flux        with half of the flux reference (`ControlReference::flux_share`) the stator flux of a
///   machine
///               becomes half of what it is with the whole one, within ten rotor time constants, as field
///               weakening needs it
///   reset       after `reset` the same inputs give the same patterns, estimates and channels, bit for bit
///
/// It allocates, so that it belongs into tests.
template <class T = double>
class ControllerCheck {
 public:
  /// A new controller, each time with the same parameters.
  using Make = std::function<std::unique_ptr<Controller<T>>()>;

  ControllerCheck(Make make, const ConformanceParameters& parameters)
      : make_{std::move(make)}, parameters_{parameters}, result_{.seed = parameters.seed} {}

  [[nodiscard]] ConformanceResult run() {
    for (const InputRange range : {InputRange::plausible, InputRange::extreme}) {
      const std::unique_ptr<Controller<T>> controller = make_();
      const std::vector<Answer> first = answers(*controller, range);
      for (std::size_t k = 0; k < first.size(); ++k) check(first[k], k);
      controller->reset();
      compare(first, answers(*controller, range), "reset: after reset");
      compare(first, answers(*make_(), range), "reset: of a new controller");
    }
    if (parameters_.has_flux_reference) check_flux();
    return std::move(result_);
  }

 private:
  struct Answer {
    ControlMode mode{};
    GatePattern pattern{};
    std::vector<T> values{};  ///< of the estimate, then of the channels
    bool magnetised{};
    std::uint8_t sector{};
    std::size_t channels{};
  };

  [[nodiscard]] std::vector<Answer> answers(Controller<T>& controller, InputRange range) const {
    RandomPeriods<T> inputs{parameters_.seed, range, parameters_.period_ns};
    std::vector<Answer> list;
    for (int k = 0; k < parameters_.periods; ++k) {
      const ControlPeriod<T> p = inputs.next();
      const GatePattern pattern = controller.step(p.measurement, p.reference);
      const ControlEstimate<T>& e = controller.estimate();
      const std::span<const T> channels = controller.channel_values();
      Answer answer{.mode = p.reference.mode,
                    .pattern = pattern,
                    .values = {e.psi_s.alpha, e.psi_s.beta, e.psi_s_magnitude, e.torque},
                    .magnetised = e.magnetised,
                    .sector = e.sector,
                    .channels = channels.size()};
      answer.values.insert(answer.values.end(), channels.begin(), channels.end());
      list.push_back(std::move(answer));
    }
    return list;
  }

  void check_flux() {
    const std::unique_ptr<Controller<T>> controller = make_();
    FluxLoop<T> loop{*controller, parameters_};
    loop.magnetise();
    const double tau_r = parameters_.machine.tau_r();
    const double whole = loop.flux(1.0, tau_r);
    double share = 1.0;
    for (int k = 0; k < 20 && !(std::abs(share - 0.5) < 0.1); ++k)
      share = loop.flux(0.5, 0.5 * tau_r) / whole;
    if (std::abs(share - 0.5) < 0.1) return;
    result_.violations.push_back("flux: with half of the flux reference the stator flux is " +
                                 std::to_string(share) + " of that with the whole one, and not half of it");
  }

  void check(const Answer& answer, std::size_t period) {
    bool negative = false;
    bool all_off = true;
    for (const GateSegment& segment : answer.pattern.segments()) {
      negative = negative || segment.duration_ns < 0;
      all_off = all_off && segment.state == gates_off;
    }
    const bool off = answer.mode == ControlMode::off;
    const bool fills =
        answer.pattern.duration_ns() == parameters_.period_ns || (off && answer.pattern.segments().empty());
    require(fills, "period: the pattern does not fill the control period", period);
    require(!negative, "durations: a segment has a negative duration", period);
    require(!off || all_off, "off: a leg is driven in mode off", period);
    bool finite = true;
    for (const T value : answer.values) finite = finite && std::isfinite(value);
    require(finite, "finite: an estimate or a channel is not finite", period);
    require(answer.channels == parameters_.channels, "channels: there are more or fewer values than channels",
            period);
  }

  void compare(const std::vector<Answer>& a, const std::vector<Answer>& b, const char* what) {
    for (std::size_t k = 0; k < a.size(); ++k) {
      const bool same =
          a[k].pattern == b[k].pattern && a[k].sector == b[k].sector && a[k].magnetised == b[k].magnetised &&
          a[k].values.size() == b[k].values.size() &&
          std::memcmp(a[k].values.data(), b[k].values.data(), a[k].values.size() * sizeof(T)) == 0;
      require(same, std::string{what} + " the same inputs give another answer", k);
    }
  }

  /// Keeps the first violation of each rule; its name precedes the colon.
  void require(bool holds, const std::string& sentence, std::size_t period) {
    if (holds || result_.has(sentence.substr(0, sentence.find(':') + 1))) return;
    result_.violations.push_back(sentence + ", first in period " + std::to_string(period) + " of seed " +
                                 std::to_string(parameters_.seed));
  }

  Make make_;
  ConformanceParameters parameters_;
  ConformanceResult result_;
};

/// Checks controllers of class C with these parameters, whose `period_ns`, `actuation_delay_periods`,
/// `machine` and channels count where C has them.
template <class C, class T = double>
[[nodiscard]] ConformanceResult check_controller(const typename C::Parameters& controller,
                                                 ConformanceParameters parameters = {}) {
  if constexpr (requires { controller.period_ns; }) parameters.period_ns = controller.period_ns;
  if constexpr (requires { controller.actuation_delay_periods; })
    parameters.actuation_delay_periods = controller.actuation_delay_periods;
  if constexpr (requires { InductionMachineParameters<T>{controller.machine}; }) {
    const InductionMachineParameters<T>& m = controller.machine;
    parameters.machine = {double(m.r_s), double(m.r_r), double(m.l_ls),   double(m.l_lr),
                          double(m.l_m), m.pole_pairs,  double(m.inertia)};
  }
  if constexpr (requires { C::channels; }) parameters.channels = std::size(C::channels);
  return ControllerCheck<T>{[&controller] { return std::make_unique<C>(controller); }, parameters}.run();
}

}  // namespace sextant
