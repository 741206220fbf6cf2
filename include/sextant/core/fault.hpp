#pragma once

#include <bit>
#include <cstdint>

namespace sextant {

/// Drive faults; the value is the bit in MCU_Faults. Each latches: gates off until reset, disable, enable.
enum class Fault : std::uint8_t {
  command_lost = 0,          ///< no valid command for longer than the limit
  command_invalid = 1,       ///< the E2E state machine reached INVALID
  command_out_of_range = 2,  ///< three commands in a row beyond the contract or the configured limit
  second_master = 3,         ///< another drive sends on this drive's bus
  bus_off = 4,               ///< the CAN controller left the bus
  measurement_invalid = 5,   ///< NaN, infinity, or the power stage did not answer
  current_sum = 6,           ///< phase currents do not add up to zero
  current_sensor = 7,        ///< a current sensor is stuck
  over_current = 8,          ///< phase current above the trip level
  dc_over_voltage = 9,       ///< DC link above the trip level
  dc_under_voltage = 10,     ///< DC link below the trip level
  speed_sensor = 11,         ///< speed lost, frozen or jumping
  over_speed = 12,           ///< speed above the trip level
  over_temperature = 13,     ///< winding or inverter too hot
  torque_plausibility = 14,  ///< delivered torque does not follow the admitted torque
  open_phase = 15,           ///< a phase carries no current
  flux_lost = 16,            ///< estimated flux near zero while producing torque, or never built up
  overrun = 17,              ///< too many late control periods in a row
  watchdog = 18,             ///< the independent watchdog disabled the gates
  transmit_lost = 19         ///< status frames cannot be sent
};

inline constexpr int fault_count = 20;

/// A set of faults as bits, bit = value of Fault.
class FaultSet {
 public:
  constexpr void set(Fault f) noexcept { bits_ |= 1U << unsigned(f); }
  [[nodiscard]] constexpr bool test(Fault f) const noexcept { return (bits_ >> unsigned(f)) & 1U; }
  [[nodiscard]] constexpr bool any() const noexcept { return bits_ != 0; }
  [[nodiscard]] constexpr int count() const noexcept { return std::popcount(bits_); }
  [[nodiscard]] constexpr std::uint32_t bits() const noexcept { return bits_; }
  constexpr FaultSet& operator|=(FaultSet o) noexcept {
    bits_ |= o.bits_;
    return *this;
  }
  friend constexpr bool operator==(FaultSet, FaultSet) noexcept = default;

 private:
  std::uint32_t bits_{0};
};

[[nodiscard]] constexpr const char* to_string(Fault f) noexcept {
  switch (f) {
    case Fault::command_lost:
      return "COMMAND_LOST";
    case Fault::command_invalid:
      return "COMMAND_INVALID";
    case Fault::command_out_of_range:
      return "COMMAND_OUT_OF_RANGE";
    case Fault::second_master:
      return "SECOND_MASTER";
    case Fault::bus_off:
      return "BUS_OFF";
    case Fault::measurement_invalid:
      return "MEASUREMENT_INVALID";
    case Fault::current_sum:
      return "CURRENT_SUM";
    case Fault::current_sensor:
      return "CURRENT_SENSOR";
    case Fault::over_current:
      return "OVER_CURRENT";
    case Fault::dc_over_voltage:
      return "DC_OVER_VOLTAGE";
    case Fault::dc_under_voltage:
      return "DC_UNDER_VOLTAGE";
    case Fault::speed_sensor:
      return "SPEED_SENSOR";
    case Fault::over_speed:
      return "OVER_SPEED";
    case Fault::over_temperature:
      return "OVER_TEMPERATURE";
    case Fault::torque_plausibility:
      return "TORQUE_PLAUSIBILITY";
    case Fault::open_phase:
      return "OPEN_PHASE";
    case Fault::flux_lost:
      return "FLUX_LOST";
    case Fault::overrun:
      return "OVERRUN";
    case Fault::watchdog:
      return "WATCHDOG";
    case Fault::transmit_lost:
      return "TRANSMIT_LOST";
  }
  return "?";
}

}  // namespace sextant
