#pragma once

namespace sextant {

/// A signal of configs/interfaces/sextant.dbc, and the values that it carries.
struct SignalRange {
  const char* name;  ///< with its message: `MCU_Motion.FluxMagnitude`
  const char* unit;
  double lowest;   ///< [the signal's unit]
  double highest;  ///< [the signal's unit]

  [[nodiscard]] constexpr bool contains(double x) const noexcept { return x >= lowest && x <= highest; }
};

/// The signals whose values grow with the machine, as the contract has them.
struct ContractRanges {
  SignalRange torque_request;
  SignalRange torque_limit;
  SignalRange torque_available;
  SignalRange flux;
  SignalRange link_voltage;
  SignalRange phase_current;  ///< RMS
  SignalRange speed;          ///< [rpm]
};

[[nodiscard]] ContractRanges contract_ranges() noexcept;

}  // namespace sextant
