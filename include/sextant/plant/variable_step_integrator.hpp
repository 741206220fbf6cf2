#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/ode_problem.hpp"
#include "sextant/plant/plant_integrator.hpp"
#include "sextant/plant/smooth_solution.hpp"

namespace sextant {

/// What the integrators with a variable step have in common, Solver being `CvodeSolver` or `ErkSolver`.
///
/// While every leg is driven the solution goes on over the switching of the inverter (`SmoothSolution`),
/// unless it stops there (`AtSwitching`). Otherwise it is continued from segment to segment as long as the
/// plant's revision stays the same, and restarted at each jump of the right-hand side: where a leg is off or
/// a cable open, and where an appended system feeds back. Root finding for diode events is a solver of its
/// own, which runs only while legs are off.
template <class Plant, class Solver>
  requires(std::same_as<typename Plant::Scalar, double> && (Plant::appends_integrals || Plant::feeds_back))
class VariableStepIntegrator : public PlantIntegrator<Plant> {
 public:
  using Parameters = typename Solver::Parameters;
  using State = typename Plant::State;

  /// Throws std::runtime_error on bad parameters or when the solver cannot be set up.
  explicit VariableStepIntegrator(const Parameters& parameters = {})
      : max_events_{checked(parameters).max_events},
        over_switching_{parameters},
        goes_on_{!parameters.stops()},
        smooth_{solver(0, parameters)},
        with_events_{solver(Plant::event_count, parameters)} {}

  SEXTANT_TRUSTED_BEGIN
  [[nodiscard]] bool advance(Plant& plant, std::int64_t duration_ns) noexcept SEXTANT_NONBLOCKING override {
    if (duration_ns <= 0) return true;
    if (duration_ns <= std::numeric_limits<std::int32_t>::max()) {
      const GateSegment one{plant.inputs().state, std::int32_t(duration_ns)};
      if (continues_over({&one, 1}, plant)) return continue_over(plant, {&one, 1}, {});
    }
    over_switching_.reset();
    const bool good = plant.has_events() ? advance_through_events(plant, duration_ns)
                                         : advance_smoothly(plant, duration_ns);
    if (!good) reset();
    return good;
  }

  [[nodiscard]] bool advance_through(Plant& plant, std::span<const GateSegment> segments,
                                     std::span<State> corners) noexcept SEXTANT_NONBLOCKING override {
    if (continues_over(segments, plant)) return continue_over(plant, segments, corners);
    return PlantIntegrator<Plant>::advance_through(plant, segments, corners);
  }
  SEXTANT_TRUSTED_END

  void reset() noexcept SEXTANT_NONBLOCKING override {
    active_ = nullptr;
    over_switching_.reset();
  }

 private:
  static Parameters checked(const Parameters& parameters) {
    if (const char* reason = parameters.validate()) {
      throw std::runtime_error(std::string(Solver::name) + " integrator: " + reason);
    }
    return parameters;
  }

  /// In place of a solution that goes on, of a plant with states beside the machine's that act on it.
  struct NeverGoesOn {
    explicit NeverGoesOn(const Parameters&) noexcept {}
    void reset() noexcept {}
  };
  using OverSwitching =
      std::conditional_t<Plant::appends_integrals, SmoothSolution<Plant, Solver>, NeverGoesOn>;

  /// One that restarts at each jump.
  static Solver solver(int event_count, const Parameters& parameters) {
    const Tolerances tolerances = parameters.tolerances(true);
    std::array<double, std::size_t(Plant::size)> absolute;
    absolute.fill(tolerances.appended);
    std::fill_n(absolute.begin(), 4, tolerances.flux);
    absolute[Plant::omega] = tolerances.speed;
    absolute[Plant::theta] = tolerances.angle;
    return {ode_problem<Plant>(event_count, Plant::machine_size), parameters, tolerances.relative, absolute};
  }

  /// Makes the solver continue the plant's solution; restarts it where it holds another one.
  bool follow(Solver& solver, const Plant& plant) noexcept {
    if (active_ == &solver && revision_ == plant.revision()) return true;
    if (!solver.restart(plant.state().data())) return false;
    active_ = &solver;
    revision_ = plant.revision();
    start_ = 0.0;
    elapsed_ns_ = 0;
    return true;
  }

  bool advance_smoothly(Plant& plant, std::int64_t duration_ns) noexcept {
    if (!follow(smooth_, plant)) return false;
    elapsed_ns_ += duration_ns;
    State x;
    if (smooth_.advance(&plant, end_time(), x.data()) != SolverOutcome::reached) return false;
    plant.continue_at(x);
    return true;
  }

  bool advance_through_events(Plant& plant, std::int64_t duration_ns) noexcept {
    const Plant before = plant;
    const bool good = follow(with_events_, plant) && reach_through_events(plant, duration_ns);
    if (!good) plant = before;
    return good;
  }

  bool reach_through_events(Plant& plant, std::int64_t duration_ns) noexcept {
    elapsed_ns_ += duration_ns;
    for (int events = 0; events <= max_events_; ++events) {
      State x;
      const SolverOutcome outcome = with_events_.advance(&plant, end_time(), x.data());
      if (outcome == SolverOutcome::failed) return false;
      plant.continue_at(x);
      if (outcome == SolverOutcome::reached) return true;
      const double left = end_time() - with_events_.time();
      plant.on_event(with_events_.event());
      if (!follow(with_events_, plant)) return false;
      if (left <= 0.0) return true;
      start_ = left;
    }
    return false;
  }

  /// End of the present segment on the solver's clock, which is zero at its restart. Whole nanoseconds are
  /// counted apart, so that a long run loses no precision. [s]
  [[nodiscard]] double end_time() const noexcept { return start_ + 1e-9 * double(elapsed_ns_); }

  [[nodiscard]] bool continues_over(std::span<const GateSegment> segments,
                                    const Plant& plant) const noexcept {
    return Plant::appends_integrals && goes_on_ && !segments.empty() && plant.is_driven_by(segments);
  }

  bool continue_over(Plant& plant, std::span<const GateSegment> segments, std::span<State> corners) noexcept {
    active_ = nullptr;
    if constexpr (Plant::appends_integrals)
      return over_switching_.advance(plant, segments, corners);
    else
      return false;
  }

  int max_events_;
  OverSwitching over_switching_;
  bool goes_on_;
  Solver smooth_;
  Solver with_events_;
  Solver* active_{nullptr};    ///< the solver that holds the plant's solution
  std::uint64_t revision_{};   ///< of the plant at the last restart
  double start_{};             ///< of the first whole segment, on the solver's clock [s]
  std::int64_t elapsed_ns_{};  ///< whole segments since then [ns]
};

}  // namespace sextant
