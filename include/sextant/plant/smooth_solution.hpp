#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/plant/error_control.hpp"
#include "sextant/plant/ode_problem.hpp"
#include "sextant/plant/segment_corners.hpp"
#include "sextant/plant/smooth_plant.hpp"
#include "sextant/plant/smooth_state.hpp"
#include "sextant/plant/voltage_integral.hpp"

namespace sextant {

/// The solution of a plant whose legs are all driven, by a solver with a variable step that goes on over the
/// switching of the inverter: it moves the smooth state (`SmoothPlant`) and stops at the end of the gate
/// segments it is given, because the voltage beyond is not known. It restarts when the plant has jumped, and
/// when a smooth flux has grown to `most_fluxes` times the largest flux so far, because the relative
/// tolerance counts for the smooth state.
template <class Plant, class Solver>
class SmoothSolution {
 public:
  using State = typename Plant::State;

  /// Throws std::runtime_error when the solver cannot be set up.
  explicit SmoothSolution(const typename Solver::Parameters& parameters)
      : solver_{solver(parameters)}, max_steps_{parameters.max_steps} {}

  /// Over gate segments that are all driven; corners as in `PlantIntegrator::advance_through`. False when the
  /// solver failed; the plant is then as it was.
  [[nodiscard]] bool advance(Plant& plant, std::span<const GateSegment> segments,
                             std::span<State> corners) noexcept {
    if (!follow(plant)) return false;
    const VoltageIntegral<double> voltage{segments, plant.inputs().u_dc};
    const double begin = time();
    elapsed_ns_ += voltage.duration_ns();
    const double h = time() - begin;
    const VoltageMoments<> end{at_end_.v + voltage.end().v, at_end_.a + h * at_end_.v + voltage.end().a};
    const SmoothPlant<Plant> smooth{plant, voltage, begin, at_end_};
    SegmentCorners<Plant> at_corners{plant, segments, voltage, corners};
    const bool good = at_corners.wanted() ? integrate_by_steps(smooth, at_corners) : integrate(smooth);
    if (!good) {
      reset();
      return false;
    }
    at_end_ = end;
    plant.continue_at(at_corners.finish(SmoothState<Plant>{plant}.machine(x_, end)));
    plant.set_switch_state(segments.back().state);
    return true;
  }

  /// The next advance begins anew.
  void reset() noexcept { jumps_ = 0; }

 private:
  using MachineState = typename Plant::MachineState;
  static constexpr double most_fluxes = 4.0;

  static Solver solver(const typename Solver::Parameters& parameters) {
    const Tolerances tolerances = parameters.tolerances(false);
    std::array<double, std::size_t(Plant::machine_size)> absolute{};
    absolute.fill(tolerances.flux);
    absolute[Plant::omega] = tolerances.speed;
    absolute[Plant::theta] = tolerances.angle;
    return {ode_problem<SmoothPlant<Plant>>(0, Plant::machine_size), parameters, tolerances.relative,
            absolute};
  }

  /// Makes the solver continue the plant's solution; restarts it where it holds another one.
  bool follow(const Plant& plant) noexcept {
    largest_flux_ = std::max(largest_flux_, magnitude(plant.psi_s()));
    if (jumps_ == plant.jumps() && largest_smooth_flux() <= most_fluxes * largest_flux_) return true;
    x_ = plant.state().template head<Plant::machine_size>();
    at_end_ = {};
    if (!solver_.restart(x_.data())) return false;
    jumps_ = plant.jumps();
    elapsed_ns_ = 0;
    return true;
  }

  [[nodiscard]] double largest_smooth_flux() const noexcept {
    return std::max(std::hypot(x_[Plant::psi_s_alpha], x_[Plant::psi_s_beta]),
                    std::hypot(x_[Plant::psi_r_alpha], x_[Plant::psi_r_beta]));
  }

  /// To the present time in one go.
  bool integrate(const SmoothPlant<Plant>& smooth) noexcept {
    return solver_.advance(&smooth, time(), x_.data()) == SolverOutcome::reached;
  }

  /// The same step by step, with the corners within each. There V and A begin at zero with the segments.
  bool integrate_by_steps(const SmoothPlant<Plant>& smooth, SegmentCorners<Plant>& at_corners) noexcept {
    const double end = time();
    double t = smooth.begin();
    MachineState y, dy;
    smooth.from_begin(t, x_, y, dy);
    at_corners.begin(y, dy);
    for (int n = 0; n < max_steps_; ++n) {
      if (solver_.step(&smooth, end, x_.data()) != SolverOutcome::reached) return false;
      const double h = solver_.time() - t;
      t = solver_.time();
      smooth.from_begin(t, x_, y, dy);
      at_corners.step(h, y, dy);
      if (t >= end) return true;
    }
    return false;
  }

  /// Since the solver's restart. Whole nanoseconds are counted, so that a long run loses no precision. [s]
  [[nodiscard]] double time() const noexcept { return 1e-9 * double(elapsed_ns_); }

  Solver solver_;
  int max_steps_;
  std::uint64_t jumps_{0};     ///< of the plant at the last restart; 0: the next advance restarts
  std::int64_t elapsed_ns_{};  ///< [ns]
  MachineState x_{};           ///< the smooth state there
  VoltageMoments<> at_end_{};  ///< V and A there
  double largest_flux_{};      ///< of the plant so far [Wb]
};

}  // namespace sextant
