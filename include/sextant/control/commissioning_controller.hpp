#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "sextant/control/current_staircase.hpp"
#include "sextant/control/estimating_controller.hpp"
#include "sextant/control/level_measurement.hpp"
#include "sextant/core/two_level_inverter.hpp"

namespace sextant {

/// Measures inverter and stator at standstill: it makes no torque, whatever the reference, but leads a direct
/// current along phase a through a `CurrentStaircase` and publishes, level by level, mean current and mean
/// commanded voltage. With i_b = i_c = −i/2 a steady level shows
///   u = R i + (4/3)(u_dc t_d/t_period + V_t) sign(i),   R = R_s + r
/// with dead time t_d, threshold voltage V_t and slope resistance r of the inverter, as each leg loses
/// sign(i_x)(u_dc t_d/t_period + V_t + r |i_x|) in a period (`InverterModel`). One voltage of the link does
/// not tell t_d from V_t.
///
/// The current follows by a PI controller in the stationary frame, per axis
///   u = K (i* − i) + v,   v[k+1] = v + (R t_period/σL_s)(K (i* − i) + u_real − u)
///   K = 0.2 σL_s/t_period,   R = R_s + k_r² R_r
/// whose zero meets the pole of the machine at standstill. It knows neither the delay nor the inverter: with
/// half the leakage inductance and two periods of delay z³ − z² + 0.4 still has all zeros within the unit
/// circle. While the rotor's EMF decays the current is off by no more than I/(0.2 τ_r/t_period).
///
/// The levels begin when torque is enabled, and anew after gates off; behind the last the current is held at
/// zero. The flux is that of the current model: what the machine's voltage tells is the unknown here.
/// Source: the staircase of direct currents of N. Bedetti, S. Calligaro, R. Petrella, "Self-commissioning of
/// inverter dead-time compensation by multiple linear regression based on a physical model", IEEE Trans. Ind.
/// Appl. 51 (2015) 3954–3964.
template <class T = double>
class CommissioningController final : public EstimatingController<T> {
 public:
  static constexpr const char* name = "commissioning";
  static constexpr const char* meaning =
      "no torque: levels of direct current that measure inverter and stator";

  static constexpr std::array channels{
      ControlChannel{"level", "1", "levels of current that are over"},
      ControlChannel{"finished", "1", "1 once every level is over"},
      ControlChannel{"direct_current_a", "A", "reference of the current along phase a"},
      ControlChannel{"level_current_a", "A", "mean reading of the current along phase a, of the last level"},
      ControlChannel{"level_voltage_v", "V", "mean commanded voltage along phase a, of the last level"},
      ControlChannel{"level_link_v", "V", "mean link voltage of the last level"},
      ControlChannel{"level_scatter_a", "A",
                     "standard deviation of the current's readings in the last level"},
      ControlChannel{"level_drift_v", "V",
                     "by how much the voltage rose from half to half of the last level"}};

  struct Parameters : EstimatingController<T>::Parameters {
    T highest_current{T(20)};             ///< limit of the current [A]
    int levels{4};                        ///< of each sign [-]
    std::int64_t settle_ns{735'000'000};  ///< before a level counts [ns]
    std::int64_t hold_ns{100'000'000};    ///< for which a level counts [ns]

    /// Seven rotor time constants: of a step of the rotor's EMF a thousandth is left. [ns]
    [[nodiscard]] static std::int64_t default_settle_ns(
        const InductionMachineParameters<T>& machine) noexcept {
      return std::llround(T(7e9) * machine.tau_r());
    }
    void set_defaults(const ControlBasis<T>& basis) noexcept {
      EstimatingController<T>::Parameters::set_defaults(basis);
      highest_current = this->magnetiser.current_limit;
      settle_ns = default_settle_ns(basis.machine);
    }

    [[nodiscard]] const char* validate() const noexcept {
      if (const char* problem = EstimatingController<T>::Parameters::validate()) return problem;
      if (!(std::isfinite(highest_current) && highest_current > T(0)))
        return "the current limit must be above zero";
      if (levels < 2) return "two levels of each sign are needed at least";
      if (hold_ns < 2 * std::int64_t{this->period_ns} || settle_ns < this->period_ns)
        return "a level must settle for a control period and last for two at least";
      constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max() / 2;
      if (hold_ns / this->period_ns > most || settle_ns / this->period_ns > most)
        return "a level must not last that many control periods";
      return nullptr;
    }
  };

  explicit CommissioningController(const Parameters& parameters) noexcept
      : Base{prepared(parameters)},
        staircase_{staircase(parameters)},
        hold_periods_{periods(parameters.hold_ns, parameters.period_ns)},
        level_{hold_periods_},
        gain_{loop_share * parameters.machine.sigma_l_s() / Base::period()},
        integral_share_{pole_share(parameters)} {}

  [[nodiscard]] std::span<const T> channel_values() const noexcept SEXTANT_NONBLOCKING override {
    return values_;
  }

 private:
  using Base = EstimatingController<T>;
  using typename Base::Demand;

  static constexpr T loop_share = T(0.2);  ///< of an error that a period takes away [-]
  /// Of the limit that the highest level leaves to errors of control and readings. [-]
  static constexpr T reserve = T(0.05);

  [[nodiscard]] static Parameters prepared(Parameters p) noexcept {
    p.flux_estimator = FluxEstimatorKind::current_model;
    p.adapts_parameters = false;
    return p;
  }
  [[nodiscard]] static std::int32_t periods(std::int64_t ns, std::int32_t period_ns) noexcept {
    constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max() / 2;
    return std::int32_t(std::clamp<std::int64_t>((ns + period_ns - 1) / period_ns, 1, most));
  }
  /// A ramp over the whole limit takes a tenth of the time for settling.
  [[nodiscard]] static CurrentStaircase<T> staircase(const Parameters& p) noexcept {
    const std::int32_t settle = periods(p.settle_ns, p.period_ns);
    const T highest = (T(1) - reserve) * p.highest_current;
    return CurrentStaircase<T>{{.highest = highest,
                                .levels = std::max(2, p.levels),
                                .slope = T(10) * highest / T(settle),
                                .settle_periods = settle,
                                .hold_periods = periods(p.hold_ns, p.period_ns)}};
  }
  /// R t_period/σL_s, at most the whole. [-]
  [[nodiscard]] static T pole_share(const Parameters& p) noexcept {
    const T resistance = p.machine.r_s + p.machine.k_r() * p.machine.k_r() * p.machine.r_r;
    return std::min(T(1), resistance * T(p.period_ns) * T(1e-9) / p.machine.sigma_l_s());
  }

  [[nodiscard]] GatePattern follow(const Demand& demand) noexcept SEXTANT_NONBLOCKING override {
    const SpaceVector<T> i = Base::estimator().i_s();
    const T reference = staircase_.step();
    const SpaceVector<T> proportional = gain_ * (SpaceVector<T>{reference, T(0)} - i);
    const SpaceVector<T> u = proportional + integral_;
    integral_ += integral_share_ * (proportional + Base::realised(u, demand.u_dc) - u);
    const GatePattern pattern = Base::modulate(u, demand.u_dc);
    measure(i.alpha, (T(1) / Base::period()) * volt_seconds(pattern, demand.u_dc).alpha, demand.u_dc);
    values_[2] = reference;
    return pattern;
  }

  /// i [A], commanded u of the coming period [V], u_dc [V].
  void measure(T i, T u, T u_dc) noexcept {
    if (!staircase_.holds()) {
      values_[1] = staircase_.is_done() ? T(1) : T(0);
      return;
    }
    level_.add(i, u, u_dc);
    if (!staircase_.ends_level()) return;
    values_ = {T(staircase_.index() + 1), values_[1],    values_[2],       level_.current(),
               level_.voltage(),          level_.link(), level_.scatter(), level_.drift()};
    level_ = LevelMeasurement<T>{hold_periods_};
  }

  void release() noexcept SEXTANT_NONBLOCKING override {
    staircase_.reset();
    level_ = LevelMeasurement<T>{hold_periods_};
    integral_ = {};
    values_ = {};
  }
  void forget() noexcept SEXTANT_NONBLOCKING override { release(); }

  CurrentStaircase<T> staircase_;
  std::int32_t hold_periods_;  ///< [-]
  LevelMeasurement<T> level_;
  T gain_;                                   ///< K [V/A]
  T integral_share_;                         ///< R t_period/σL_s [-]
  SpaceVector<T> integral_{};                ///< v [V]
  std::array<T, channels.size()> values_{};  ///< of the channels
};

}  // namespace sextant
