#pragma once

#include <cstddef>
#include <span>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/appended_system.hpp"
#include "sextant/plant/cubic.hpp"
#include "sextant/plant/smooth_state.hpp"
#include "sextant/plant/voltage_integral.hpp"

namespace sextant {

/// The corners of gate segments for an integrator that does not stop at them. Within each of its steps the
/// states at the corners follow by cubic Hermite interpolation of the smooth state (`SmoothState`), and an
/// appended system of integrals by Simpson's rule over each segment. may_lose: the inverter may have a
/// threshold.
template <class Plant, bool may_lose = false>
  requires(Plant::appends_integrals)
class SegmentCorners {
 public:
  using T = typename Plant::Scalar;
  using State = typename Plant::State;
  using MachineState = typename Plant::MachineState;

  /// Begins at the plant's present state; the plant, all segments and their voltage must outlive this object.
  /// corners: where the state at the end of each segment goes, or empty.
  SegmentCorners(const Plant& plant, std::span<const GateSegment> segments, const VoltageIntegral<T>& voltage,
                 std::span<State> corners) noexcept SEXTANT_NONBLOCKING : plant_{plant},
                                                                          segments_{segments},
                                                                          voltage_{voltage},
                                                                          corners_{corners},
                                                                          smooth_state_{plant},
                                                                          x_{plant.state()} {
    if constexpr (has_integrals) q_ = quantities(machine_part(x_));
  }

  /// True where somebody asks for corners or integrals: then each step has to be told.
  [[nodiscard]] bool wanted() const noexcept SEXTANT_NONBLOCKING {
    return has_integrals || !corners_.empty();
  }

  /// The smooth state at the beginning of the segments, where V and A are zero, and its slope.
  void begin(const MachineState& smooth, const MachineState& slope) noexcept SEXTANT_NONBLOCKING {
    smooth_ = smooth;
    slope_ = slope;
  }

  /// A step of the integrator over h [s], and smooth state and slope at its end.
  void step(T h, const MachineState& smooth, const MachineState& slope) noexcept SEXTANT_NONBLOCKING {
    path_.set(smooth_, slope_, smooth, slope, h);
    const T end = t_ + h;
    T from = t_;
    for (; segment_ + 1 < segments_.size() && voltage_.corner(segment_) < end; ++segment_) {
      const T corner = voltage_.corner(segment_);
      advance(from, corner, smooth_state_.machine(path_(corner - t_), voltage_.at_corner(segment_)));
      if (!corners_.empty()) corners_[segment_] = x_;
      from = corner;
    }
    if constexpr (has_integrals) advance(from, end, smooth_state_.machine(smooth, voltage_(end)));
    t_ = end;
    smooth_ = smooth;
    slope_ = slope;
  }

  /// The state at the end of all segments, with the machine's part as the integrator has found it.
  [[nodiscard]] State finish(const MachineState& end) noexcept SEXTANT_NONBLOCKING {
    machine_part(x_) = end;
    if (!corners_.empty()) corners_[segments_.size() - 1] = x_;
    return x_;
  }

 private:
  static constexpr bool has_integrals = Plant::size > Plant::machine_size;

  static auto machine_part(State& x) noexcept { return x.template head<Plant::machine_size>(); }
  static MachineState machine_part(const State& x) noexcept { return x.template head<Plant::machine_size>(); }

  [[nodiscard]] PlantQuantities<T> quantities(const MachineState& x) const noexcept SEXTANT_NONBLOCKING {
    PlantQuantities<T> q = plant_.quantities(x);
    if constexpr (may_lose) q.threshold_loss = plant_.drops().threshold_loss(q.i_s);
    return q;
  }

  /// From one time to another [s] within the present segment and step, at which the machine's state is `end`.
  void advance(T from, T to, const MachineState& end) noexcept SEXTANT_NONBLOCKING {
    if constexpr (has_integrals) {
      const SwitchState state = segments_[segment_].state;
      const T length = to - from;
      const T half = from + T(0.5) * length;
      PlantQuantities<T> middle =
          quantities(smooth_state_.machine(path_(half - t_), voltage_.within(segment_, half)));
      const auto k0 = plant_.integral_derivative(q_, state);
      const auto k1 = plant_.integral_derivative(middle, state);
      q_ = quantities(end);
      const auto k2 = plant_.integral_derivative(q_, state);
      for (std::size_t i = 0; i < k0.size(); ++i)
        x_[Plant::machine_size + int(i)] += (length / T(6)) * (k0[i] + T(4) * k1[i] + k2[i]);
    }
    machine_part(x_) = end;
  }

  const Plant& plant_;
  std::span<const GateSegment> segments_;
  const VoltageIntegral<T>& voltage_;
  std::span<State> corners_;
  SmoothState<Plant> smooth_state_;
  std::size_t segment_{0};      ///< the present one
  T t_{0};                      ///< end of the last step [s]
  MachineState smooth_{};       ///< smooth state at the end of the last step
  MachineState slope_{};        ///< its slope there
  Cubic<MachineState> path_{};  ///< of the smooth state over the present step
  State x_;                     ///< at the last corner or end of a step
  PlantQuantities<T> q_{};      ///< there
};

}  // namespace sextant
