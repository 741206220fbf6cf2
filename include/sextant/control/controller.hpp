#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Mode of the controller in the coming period.
enum class ControlMode : std::uint8_t {
  off,        ///< all gates off; the controller updates its estimate
  magnetise,  ///< build up flux without torque
  torque      ///< follow the torque reference
};

template <class T = double>
struct ControlReference {
  ControlMode mode{ControlMode::off};
  T torque{};          ///< T_ref, used in mode `torque` [N·m]
  T flux_share{T(1)};  ///< stator flux reference as a share of the configured one, in (0, 1] [-]
};

/// A controller's estimate of the machine's state.
template <class T = double>
struct ControlEstimate {
  SpaceVector<T> psi_s{};  ///< stator flux linkage, stationary frame [Wb]
  T psi_s_magnitude{};     ///< [Wb]
  T torque{};              ///< electromagnetic torque [N·m]
  T torque_ripple{};       ///< of over-modulation's harmonics when the coming pattern begins; 0: none [N·m]
  std::uint8_t sector{};   ///< sector of ψ_s, 1…6; 0 without flux, or without sectors
  bool magnetised{false};  ///< the flux is ready for torque
  T r_s{};                 ///< stator resistance in use; 0 where the controller tells none [Ω]
  T r_r{};                 ///< the same of the rotor [Ω]
  T l_m{};                 ///< the same of the magnetising inductance [H]
  T r_s_deviation{};       ///< relative standard deviation of `r_s`; 0 where the controller tells none [-]
  T r_r_deviation{};       ///< the same of `r_r` [-]
  T l_m_deviation{};       ///< the same of `l_m` [-]
};

/// A quantity that a controller gives to traces beside its estimate.
struct ControlChannel {
  const char* name;         ///< of its column in the group `control` of a trace, with its unit: `i_d_a`
  const char* unit;         ///< "1" where it has none
  const char* description;  ///< one line
};

/// Most channels of one controller.
inline constexpr std::size_t control_channel_capacity = 16;

/// What a controller was built for; zero where it does not tell.
struct ControlTiming {
  std::int32_t period_ns{0};         ///< control period [ns]
  std::int32_t sampling_lead_ns{0};  ///< from the sample of the currents to the period [ns]
};

/// The seam behind which control methods are exchanged: measurement and reference in, gate pattern out. The
/// estimate is a member and not a virtual function, because the drive reads it in every period.
template <class T = double>
class Controller {
 public:
  Controller() = default;
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;
  virtual ~Controller() = default;

  /// One control period: updates the estimate from the measurement and decides the coming pattern. To be
  /// called in every period, also with the gates off.
  [[nodiscard]] virtual GatePattern step(const Measurement<T>& measurement,
                                         ControlReference<T> reference) noexcept SEXTANT_NONBLOCKING = 0;

  /// Back to the state after power-up: no flux, comparators at rest.
  virtual void reset() noexcept SEXTANT_NONBLOCKING = 0;

  /// A fault is over, which may have misled the controller: back to the state after power-up, but for the
  /// rotor flux that the machine keeps, where the controller knows it.
  virtual void restart() noexcept SEXTANT_NONBLOCKING { reset(); }

  /// Whether `take_parameters` takes all that may change while torque is made: the current limit of the drive
  /// and what its keys say so of.
  [[nodiscard]] virtual bool takes_parameters() const noexcept { return false; }

  /// Takes these parameters from a controller of the same class, machine, inverter, flux reference and period
  /// between two steps; what follows from the past stays. To be called where `takes_parameters`.
  virtual void take_parameters(const Controller& /*from*/) noexcept SEXTANT_NONBLOCKING {}

  /// Values of the channels that the class declares as `channels`, in the same order, after the last step.
  [[nodiscard]] virtual std::span<const T> channel_values() const noexcept SEXTANT_NONBLOCKING { return {}; }

  /// A drive of another period or sampling instant is refused (`Drive::Parameters::validate`).
  [[nodiscard]] virtual ControlTiming timing() const noexcept { return {}; }

  /// Whether the mean torque of the estimate meets its reference in a steady state, so that what it misses at
  /// the voltage limit is a lack of voltage (`VoltageReserve`). Without that it may miss it by the torque
  /// that an active vector adds in one period.
  [[nodiscard]] virtual bool holds_mean_torque() const noexcept { return false; }

  /// Whether the voltage follows its reference beyond u_dc/√3, up to six-step. Other controllers are refused
  /// with a larger share of the voltage (`Drive::Parameters::validate`).
  [[nodiscard]] virtual bool reaches_six_step() const noexcept { return false; }

  /// The estimate at the last measurement.
  [[nodiscard]] const ControlEstimate<T>& estimate() const noexcept SEXTANT_NONBLOCKING { return estimate_; }

 protected:
  ControlEstimate<T> estimate_{};  ///< kept up to date by `step` and `reset`
};

}  // namespace sextant
