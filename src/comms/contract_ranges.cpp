#include "sextant/comms/contract_ranges.hpp"

#include "sextant_contract.hpp"

namespace sextant {
namespace {

template <class Raw>
constexpr SignalRange range_of(const contract::Signal<Raw>& signal) noexcept {
  return {.name = signal.name, .unit = signal.unit, .lowest = signal.minimum, .highest = signal.maximum};
}

}  // namespace

ContractRanges contract_ranges() noexcept {
  return {.torque_request = range_of(contract::vcu_torque_command_torque_request),
          .torque_limit = range_of(contract::vcu_torque_command_torque_limit),
          .torque_available = range_of(contract::mcu_capability_torque_motoring),
          .flux = range_of(contract::mcu_motion_flux_magnitude),
          .link_voltage = range_of(contract::mcu_electrical_dc_voltage),
          .phase_current = range_of(contract::mcu_electrical_phase_current_rms),
          .speed = range_of(contract::mcu_motion_speed)};
}

}  // namespace sextant
