#pragma once

#include <cstddef>
#include <cstdint>

#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant {

/// What controllers are checked with (`check_controller`).
struct ConformanceParameters {
  std::int32_t period_ns{25'000};  ///< control period of the controllers [ns]
  std::uint64_t seed{1};           ///< of the inputs
  int periods{5'000};              ///< of each sequence of inputs [-]
  std::size_t channels{0};         ///< channels that the class declares [-]
  bool has_flux_reference{true};   ///< false: the method sets its flux itself, as in commissioning
  int actuation_delay_periods{0};  ///< from a decision to its pattern, 0 or 1 [-]
  double u_dc{530.0};              ///< link voltage of the machine with which the flux is checked [V]
  InductionMachineParameters<double> machine{};  ///< that machine
};

}  // namespace sextant
