#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include <Eigen/Core>

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/ode_problem.hpp"
#include "sextant/plant/plant_integrator.hpp"

namespace sextant {

/// What the integrators with a variable step have in common, Solver being `CvodeSolver` or `ErkSolver`. The
/// solution is continued from segment to segment as long as the plant's revision stays the same, and
/// restarted at each jump of the right-hand side. Root finding for diode events is a second solver that runs
/// only while legs are off.
template <class Plant, class Solver>
  requires std::same_as<typename Plant::Scalar, double>
class VariableStepIntegrator : public PlantIntegrator<Plant> {
 public:
  using Parameters = typename Solver::Parameters;

  /// Throws std::runtime_error on bad parameters or when the solver cannot be set up.
  explicit VariableStepIntegrator(const Parameters& parameters = {})
      : max_events_{checked(parameters).max_events},
        smooth_{problem(0), parameters, tolerances(parameters)},
        with_events_{problem(Plant::event_count), parameters, tolerances(parameters)} {}

  SEXTANT_TRUSTED_BEGIN
  [[nodiscard]] bool advance(Plant& plant, std::int64_t duration_ns) noexcept SEXTANT_NONBLOCKING override {
    if (duration_ns <= 0) return true;
    const bool good = plant.has_events() ? advance_through_events(plant, duration_ns)
                                         : advance_smoothly(plant, duration_ns);
    if (!good) reset();
    return good;
  }
  SEXTANT_TRUSTED_END

  void reset() noexcept SEXTANT_NONBLOCKING override { active_ = nullptr; }

 private:
  using State = typename Plant::State;

  static Parameters checked(const Parameters& parameters) {
    if (const char* reason = parameters.validate()) {
      throw std::runtime_error(std::string(Solver::name) + " integrator: " + reason);
    }
    return parameters;
  }

  static OdeProblem problem(int event_count) noexcept {
    return {Plant::size,
            event_count,
            [](const void* plant, const double* x, double* dx) noexcept {
              State slope;
              static_cast<const Plant*>(plant)->derivative(Eigen::Map<const State>(x), slope);
              Eigen::Map<State>{dx} = slope;
            },
            [](const void* plant, const double* x, double* j) noexcept {
              typename Plant::Jacobian matrix;
              static_cast<const Plant*>(plant)->jacobian(Eigen::Map<const State>(x), matrix);
              Eigen::Map<typename Plant::Jacobian>{j} = matrix;
            },
            [](const void* plant, const double* x, double* g) noexcept {
              std::array<double, Plant::event_count> values;
              static_cast<const Plant*>(plant)->events(Eigen::Map<const State>(x), values);
              std::copy(values.begin(), values.end(), g);
            },
            Plant::machine_size};
  }

  static std::array<double, Plant::size> tolerances(const Parameters& parameters) noexcept {
    std::array<double, Plant::size> t;
    t.fill(parameters.appended_tolerance);
    std::fill_n(t.begin(), 4, parameters.flux_tolerance);
    t[Plant::omega] = parameters.speed_tolerance;
    t[Plant::theta] = parameters.angle_tolerance;
    return t;
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

  int max_events_;
  Solver smooth_;
  Solver with_events_;
  Solver* active_{nullptr};    ///< the solver that holds the plant's solution
  std::uint64_t revision_{};   ///< of the plant at the last restart
  double start_{};             ///< of the first whole segment, on the solver's clock [s]
  std::int64_t elapsed_ns_{};  ///< whole segments since then [ns]
};

}  // namespace sextant
