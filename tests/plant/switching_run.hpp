#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "sextant/core/switch_state.hpp"
#include "sextant/plant/drive_plant_parameters.hpp"
#include "sextant/plant/plant_integrator.hpp"

namespace sextant {

constexpr std::int64_t switching_period_ns = 25'000;

/// 530 V and a load of 5 N·m, gates off.
template <class T = double>
PlantInputs<T> supply() {
  PlantInputs<T> inputs{};
  inputs.u_dc = T(530);
  inputs.tau_l = T(5);
  return inputs;
}

/// A sequence of switching states at 25 µs that turns the flux at about 25 Hz: for each sixth of a turn a
/// random mix of its active vector and both zero vectors.
inline std::vector<SwitchState> switching_sequence(std::size_t periods, unsigned seed) {
  constexpr std::size_t periods_per_sixth = 267;
  std::mt19937 random{seed};
  std::vector<SwitchState> sequence;
  for (std::size_t n = 0; n < periods; ++n) {
    const std::size_t active = 1 + (n / periods_per_sixth) % 6;
    const auto draw = random() % 4U;
    sequence.push_back(switch_states[draw < 2 ? active : draw == 2 ? 0 : 7]);
  }
  return sequence;
}

/// Runs the plant through a switching sequence; false when the integrator failed.
template <class Plant>
bool run(Plant& plant, PlantIntegrator<Plant>& integrator, const std::vector<SwitchState>& sequence,
         PlantInputs<typename Plant::Scalar> inputs) {
  for (const SwitchState state : sequence) {
    inputs.state = state;
    plant.set_inputs(inputs);
    if (!integrator.advance(plant, switching_period_ns)) return false;
  }
  return true;
}

}  // namespace sextant
