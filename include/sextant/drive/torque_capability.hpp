#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "sextant/drive/available_torque.hpp"
#include "sextant/drive/voltage_demand.hpp"

namespace sextant {

/// The torque that machine and link can produce at a speed, and the flux at which they do. At constant
/// relative slip x all voltages and currents go with the flux, and the torque with its square. With s, the
/// square of the flux's share of its reference ψ, `steady_state` and `VoltageDemand` give
///   τ(x) = 2 T_b x/m(x),   m(x) = (1 + x²)/s = max(1 + x², N(x) (ψ/U)²),   U = voltage_use · u_dc/√3
/// The available torque is the largest τ(x) with
///   τ_e of at most `breakdown_use` of the breakdown torque at the flux                (x ≤ x_max)
///   |i_s|² = (ψ/L_s)² (1 + x²/σ²)/m(x) ≤ current_limit²
/// x comes from a bisection. So the flux is constant at low speed, then as large as the voltage allows, and
/// the torque then limited by the voltage or by x_max. A configured curve narrows the motoring torque
/// further: full up to its base speed, from there falling linearly to zero at its zero-torque speed.
template <class T = double>
class TorqueCapability {
 public:
  struct Parameters {
    static constexpr T unlimited = std::numeric_limits<T>::infinity();

    InductionMachineParameters<T> machine{};  ///< the controller's parameters of the machine
    T flux_reference{T(1.1)};                 ///< ψ [Wb]
    T voltage_use{T(1)};       ///< share of u_dc/√3 that a steady state may need, up to that of six-step [-]
    T breakdown_use{T(0.95)};  ///< share of the breakdown torque at the flux that may be used [-]
    T current_limit{T(160)};   ///< peak of the stator current vector [A]
    T torque{T(150)};          ///< largest magnitude, at any speed [N·m]
    T base_speed{unlimited};   ///< of the configured curve; unlimited: its zero-torque speed [rad/s]
    T zero_torque_speed{unlimited};  ///< of the configured curve; unlimited: no curve [rad/s]

    [[nodiscard]] const char* validate() const noexcept {
      if (const char* problem = machine.validate()) return problem;
      if (!(std::isfinite(flux_reference) && flux_reference > T(0))) {
        return "the flux reference must be above zero";
      }
      if (!(voltage_use > T(0) && voltage_use <= six_step_share<T>)) {
        return "the share of voltage must be above 0 and at most 2 sqrt(3)/pi, that of six-step";
      }
      if (!(breakdown_use > T(0) && breakdown_use <= T(1))) {
        return "the share of the breakdown torque must be in (0, 1]";
      }
      // More torque takes more current from √2 of the current without torque on.
      if (!(std::isfinite(current_limit) && current_limit * machine.l_s() > T(1.5) * flux_reference)) {
        return "the current limit must be above 1.5 times the current that the flux takes without torque";
      }
      if (!(std::isfinite(torque) && torque > T(0))) return "the available torque must be above zero";
      if (!(base_speed > T(0))) return "the base speed must be above zero";
      if (!(zero_torque_speed > T(0))) return "the zero-torque speed must be above zero";
      if (std::isfinite(base_speed) && !std::isfinite(zero_torque_speed)) {
        return "a base speed needs a zero-torque speed";
      }
      if (std::isfinite(base_speed) && !(zero_torque_speed > base_speed)) {
        return "the zero-torque speed must be above the base speed";
      }
      return nullptr;
    }
  };

  explicit TorqueCapability(const Parameters& p) noexcept
      : parameters_{p},
        machine_{p.machine},
        base_speed_{std::min(p.base_speed, p.zero_torque_speed)},
        twice_breakdown_{T(2) * breakdown_torque(p.machine, p.flux_reference)},
        inverse_twice_breakdown_{T(1) / twice_breakdown_},
        inverse_sigma_{square(p.machine.l_s() / p.machine.sigma_l_s())},
        current_{square(p.current_limit * p.machine.l_s() / p.flux_reference)},
        voltage_{square(linear_voltage(p.voltage_use) / p.flux_reference)},
        most_slip_{relative_slip(p.breakdown_use, T(1))},
        full_{full_flux()},
        sides_{full_, full_} {
    begin_search(motoring);
  }

  /// Takes the limits of another one for the same machine and flux reference. Those of the whole flux count
  /// at once, the others within twice `search_steps`.
  void take_parameters(const TorqueCapability& from) noexcept {
    const TorqueCapability before{*this};
    *this = from;
    sides_ = before.sides_;
    for (Side& side : sides_) side.limit.lower_to(full_.limit);
    begin_search(before.search_.side);  // by the new limits
    omega_m_ = before.omega_m_;
    inverse_voltage_ = before.inverse_voltage_;
    slip_ = before.slip_;
    is_fed_ = before.is_fed_;
    voltage_suffices_ = false;  // the next step takes both sides from the new limits
  }

  /// Takes over speed [rad/s] and link voltage [V]; `usable` is the share of the voltage's square that may be
  /// counted on. Of the searches for the two sides, in turn, a part is made in each step: a limit is at most
  /// `search_steps` old.
  void step(T omega_m, T u_dc, T usable) noexcept {
    const bool sufficed = voltage_suffices_;
    set(omega_m, u_dc, usable);
    if (voltage_suffices_) {
      if (!sufficed) restart(full_);
    } else if (is_fed_) {
      continue_search();
    } else {
      restart({{T(0), DeratingCause::voltage_limit}, T(0)});
    }
  }

  /// Steps in which both sides are searched anew. [-]
  static constexpr int search_steps = 12;

  /// Available torque by the last steps; zero without link voltage or without a speed.
  [[nodiscard]] AvailableTorque<T> available() const noexcept {
    AvailableTorque<T> found{sides_[motoring].limit, sides_[regenerating].limit};
    found.motoring.lower_to({configured_curve(), DeratingCause::none});
    return found;
  }

  /// Available torque at a speed and a link voltage.
  [[nodiscard]] AvailableTorque<T> at(T omega_m, T u_dc) const noexcept {
    TorqueCapability copy{*this};
    for (int k = 0; k < search_steps; ++k) copy.step(omega_m, u_dc, T(1));
    return copy.available();
  }

  /// Share of the flux reference, in (0, 1], at which a torque [N·m] within the available range needs no
  /// more voltage than there is: √s at the smallest x with τ(x) = |torque|, by one iteration of Newton a
  /// step.
  [[nodiscard]] T flux_share(T torque) noexcept {
    if (voltage_suffices_) return T(1);
    const std::size_t side = torque * omega_m_ < T(0) ? regenerating : motoring;
    const VoltageDemand<T> demand = demand_of(side);
    const T x = std::min(sides_[side].slip, slip_);  // in this order, which drops a NaN
    const T weakened = demand.at(x) * inverse_voltage_;
    const T full = T(1) + x * x;
    const bool is_full = weakened <= full;
    follow(std::abs(torque) * inverse_twice_breakdown_, x, is_full ? full : weakened,
           is_full ? T(2) * x : demand.slope(x) * inverse_voltage_, sides_[side].slip);
    return weakened > full ? std::max(least_share, std::sqrt(full / weakened)) : T(1);
  }

  /// A relative slip at which a torque [N·m] within the available range needs no more voltage than there is,
  /// or which takes more flux than `flux_share`: `slip` itself, else that of the largest torque. [-]
  [[nodiscard]] T within_voltage(T torque, T slip) const noexcept {
    if (voltage_suffices_) return slip;
    const std::size_t side = torque * omega_m_ < T(0) ? regenerating : motoring;
    const T share = std::abs(torque) * inverse_twice_breakdown_;
    const bool suffices = share * demand_of(side).at(slip) * inverse_voltage_ <= slip;
    return suffices ? slip : std::min(slip, sides_[side].slip);
  }

 private:
  static constexpr T least_share = T(0.05);
  static constexpr T voltage_margin = T(0.8);  // share of the voltage's square below which it is no limit
  static constexpr std::size_t motoring = 0;
  static constexpr std::size_t regenerating = 1;

  /// The largest torque of one side, and its slip. [-]
  struct Side {
    LimitedTorque<T> limit{};
    T slip{};
  };

  /// A bisection in progress.
  struct Search {
    static constexpr int all_halvings = 12;  ///< of x to 2e-4
    static constexpr int halvings_a_step = 2;

    std::size_t side{motoring};
    T below{};
    T above{};
    DeratingCause cause{DeratingCause::voltage_limit};
    int halvings{0};
  };

  static constexpr T square(T x) noexcept { return x * x; }

  /// The largest torque at the flux reference, where the voltage is no limit.
  [[nodiscard]] Side full_flux() const noexcept {
    Side side{{parameters_.torque, DeratingCause::none},
              relative_slip(parameters_.torque, T(0.5) * twice_breakdown_)};
    const auto lower_to = [&](T slip, DeratingCause cause) {
      if (slip >= side.slip) return;
      side = {{twice_breakdown_ * slip / (T(1) + slip * slip), cause}, slip};
    };
    lower_to(most_slip_, DeratingCause::none);
    if (inverse_sigma_ > current_) {
      lower_to(std::sqrt((current_ - T(1)) / (inverse_sigma_ - current_)), DeratingCause::current_limit);
    }
    return side;
  }

  /// Newton's step from x to the root of x − torque·m(x), of which m and its slope are at x.
  void follow(T torque, T x, T m, T slope, T largest) noexcept {
    const T rise = T(1) - torque * slope;
    slip_ = rise > T(0) ? std::clamp(torque * (m - x * slope) / rise, T(0), largest) : largest;
  }

  void set(T omega_m, T u_dc, T usable) noexcept {
    omega_m_ = omega_m;
    const T voltage = voltage_ * u_dc * u_dc * usable;
    is_fed_ = u_dc > T(0) && voltage > T(1) && std::isfinite(omega_m);
    // Motoring needs the most voltage, at its largest torque or without torque.
    const VoltageDemand<T> demand = demand_of(motoring);
    voltage_suffices_ =
        is_fed_ && demand.at(full_.slip) <= voltage_margin * voltage * (T(1) + full_.slip * full_.slip) &&
        demand.without_torque() <= voltage_margin * voltage;
    if (!voltage_suffices_) inverse_voltage_ = is_fed_ ? T(1) / voltage : T(1);
  }

  /// Both sides have one limit.
  void restart(const Side& side) noexcept {
    sides_ = {side, side};
    slip_ = T(0);
    begin_search(motoring);
  }

  [[nodiscard]] VoltageDemand<T> demand_of(std::size_t side) const noexcept {
    const T omega_r = T(parameters_.machine.pole_pairs) * std::abs(omega_m_);
    return {machine_, side == motoring ? omega_r : -omega_r};
  }

  [[nodiscard]] bool keeps_current(T x, T m) const noexcept {
    return T(1) + x * x * inverse_sigma_ <= current_ * m;
  }

  void begin_search(std::size_t side) noexcept { search_ = {.side = side, .above = most_slip_}; }

  /// The slip of the largest torque of a side, by bisection. Up to it the current suffices and the torque
  /// rises: at constant flux always, at constant voltage while `torque_rises`.
  void continue_search() noexcept {
    const VoltageDemand<T> demand = demand_of(search_.side);
    if (demand.at(full_.slip) * inverse_voltage_ <= T(1) + full_.slip * full_.slip) {
      end_search(full_);
      return;
    }
    for (int k = 0; k < search_.halvings_a_step; ++k) halve(demand);
    if (search_.halvings < search_.all_halvings) return;
    const T x = search_.below;
    const T m = std::max(T(1) + x * x, demand.at(x) * inverse_voltage_);
    Side found{{twice_breakdown_ * x / m, search_.cause}, x};
    found.limit.lower_to({parameters_.torque, DeratingCause::none});
    end_search(found);
  }

  void end_search(const Side& found) noexcept {
    sides_[search_.side] = found;
    begin_search(search_.side == motoring ? regenerating : motoring);
  }

  void halve(const VoltageDemand<T>& demand) noexcept {
    const T x = T(0.5) * (search_.below + search_.above);
    const T full = T(1) + x * x;
    const T weakened = demand.at(x) * inverse_voltage_;
    const bool keeps = keeps_current(x, std::max(full, weakened));
    ++search_.halvings;
    if (keeps && (weakened <= full || demand.torque_rises(x))) {
      search_.below = x;
    } else {
      search_.above = x;
      search_.cause = keeps ? DeratingCause::voltage_limit : DeratingCause::current_limit;
    }
  }

  /// Motoring torque of the configured curve. [N·m]
  [[nodiscard]] T configured_curve() const noexcept {
    const T speed = std::abs(omega_m_);
    if (speed <= base_speed_) return parameters_.torque;
    if (speed >= parameters_.zero_torque_speed) return T(0);
    const T range = parameters_.zero_torque_speed - base_speed_;
    return parameters_.torque * (parameters_.zero_torque_speed - speed) / range;
  }

  Parameters parameters_;
  typename VoltageDemand<T>::Machine machine_;
  T base_speed_;               ///< of the configured curve [rad/s]
  T twice_breakdown_;          ///< 2 T_b at the flux reference [N·m]
  T inverse_twice_breakdown_;  ///< [1/(N·m)]
  T inverse_sigma_;            ///< 1/σ² [-]
  T current_;                  ///< (current_limit · L_s/ψ)² [-]
  T voltage_;                  ///< (U/(u_dc ψ))² [1/Wb²]
  T most_slip_;                ///< x_max [-]
  Side full_;                  ///< at the flux reference
  std::array<Side, 2> sides_;
  Search search_{};
  T omega_m_{};           ///< [rad/s]
  T inverse_voltage_{1};  ///< (ψ/U)² [s²/rad²]
  T slip_{};              ///< of the torque of the last `flux_share` [-]
  bool is_fed_{true};
  bool voltage_suffices_{false};  ///< the voltage is no limit at all
};

}  // namespace sextant
