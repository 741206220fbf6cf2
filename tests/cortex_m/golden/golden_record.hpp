#pragma once

#include <cstdint>
#include <type_traits>

#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/drive/drive.hpp"
#include "sextant/plant/drive_plant_parameters.hpp"

namespace sextant::golden {

/// How the drive of a golden run is set up: the first record of a file of inputs.
struct Setup {
  std::uint32_t input_size{};  ///< of one input [B]; another one means another layout
  std::uint32_t periods{};     ///< inputs that follow [-]
  std::int32_t period_ns{25'000};
  std::int32_t actuation_delay_periods{0};
  friend constexpr bool operator==(const Setup&, const Setup&) noexcept = default;
};

/// What the drive got in one period.
struct Input {
  std::int64_t t_ns{};  ///< beginning of the period [ns]
  Measurement<float> measurement{};
  DriveRequest<float> request{};
};
// Written and read as bytes; `Setup::input_size` tells when host and target lay it out differently.
static_assert(std::is_trivially_copyable_v<Input>);

/// What the drive answered, and what it knew then. scripts/studies/microcontroller/golden.py reads it, then a PlantOutput.
struct Output {
  std::uint64_t latched{};   ///< faults, as bits
  float torque{};            ///< estimated [N·m]
  float torque_reference{};  ///< admitted [N·m]
  float psi_s_alpha{};       ///< estimated [Wb]
  float psi_s_beta{};        ///< estimated [Wb]
  float i_dc{};              ///< mean of the DC-link current [A]
  std::uint8_t legs{};       ///< gate pattern: upper switches, and from bit 3 the legs that are off
  std::uint8_t sector{};
  std::uint8_t state{};  ///< DriveState
  std::uint8_t lockout{};
};
static_assert(sizeof(Output) == 32);

/// The plant at the end of the period that ended with an input, from the applied patterns alone.
struct PlantOutput {
  float i_alpha{};  ///< [A]
  float i_beta{};   ///< [A]
  float tau_e{};    ///< [N·m]
  float omega_m{};  ///< [rad/s]
};

/// What the processor did for it in one period, in ticks of its timer. scripts/studies/microcontroller/golden.py reads it.
struct Cost {
  std::uint32_t drive{};       ///< Drive::step
  std::uint32_t controller{};  ///< DirectTorqueController::step
  std::uint32_t plant{};       ///< one period of the plant, by the fixed-step integrator
  std::uint32_t driven{};      ///< 1: every leg was driven over that period
};

template <class T>
[[nodiscard]] constexpr Output output_of(const DriveOutput<T>& step) noexcept {
  const Telemetry<T>& t = step.telemetry;
  const SwitchState legs = step.pattern.last_state();
  return {.latched = t.latched.bits(),
          .torque = float(t.torque),
          .torque_reference = float(t.torque_reference),
          .psi_s_alpha = float(t.psi_s.alpha),
          .psi_s_beta = float(t.psi_s.beta),
          .i_dc = float(t.i_dc),
          .legs = std::uint8_t(legs.upper_switches() | legs.legs_off() << 3U),
          .sector = t.sector,
          .state = std::uint8_t(t.state),
          .lockout = std::uint8_t(t.lockout)};
}

/// The controller of a golden run.
template <class T>
[[nodiscard]] typename DirectTorqueController<T>::Parameters controller_parameters(const Setup& setup) {
  typename DirectTorqueController<T>::Parameters p;
  p.period_ns = setup.period_ns;
  p.actuation_delay_periods = setup.actuation_delay_periods;
  return p;
}

/// The drive of a golden run: it magnetises first, its torque has a rate to keep, and falls early with the
/// speed.
template <class T>
[[nodiscard]] typename Drive<T>::Parameters drive_parameters(const Setup& setup) {
  typename Drive<T>::Parameters p;
  p.period_ns = setup.period_ns;
  p.magnetise_first = true;
  p.command.torque_rate = T(20'000);
  p.motor.capability.base_speed = T(60);
  p.motor.capability.zero_torque_speed = T(100);
  return p;
}

/// The plant of a golden run: a shaft so light that half a second sees many speeds.
template <class T>
[[nodiscard]] DrivePlantParameters<T> plant_parameters() {
  DrivePlantParameters<T> p;
  p.machine.inertia = T(0.008);
  return p;
}

/// On the shaft throughout. [N·m]
template <class T>
inline constexpr T load_torque = T(5);

}  // namespace sextant::golden
