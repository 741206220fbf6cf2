#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>

#include "sextant/control/current_staircase.hpp"
#include "sextant/control/estimating_controller.hpp"
#include "sextant/control/level_measurement.hpp"
#include "sextant/control/tone_measurement.hpp"
#include "sextant/control/tone_sequence.hpp"
#include "sextant/core/two_level_inverter.hpp"

namespace sextant {

/// What a `CommissioningController` excites the machine with.
enum class CommissioningCourse : std::uint8_t {
  levels,  ///< direct currents
  tones    ///< sines above a direct current
};

/// Measures inverter and machine at standstill: it makes no torque, whatever the reference, but leads a
/// current along phase a, in one of two courses, and publishes what each level of it shows.
///
/// Levels. A direct current goes through a `CurrentStaircase`; mean current and mean commanded voltage are
/// published. With i_b = i_c = −i/2 a steady level shows
///   u = R i + (4/3)(u_dc t_d/t_period + V_t) sign(i),   R = R_s + r
/// with dead time t_d, threshold voltage V_t and slope resistance r of the inverter, as each leg loses
/// sign(i_x)(u_dc t_d/t_period + V_t + r |i_x|) in a period (`InverterModel`). One voltage of the link does
/// not tell t_d from V_t.
///
/// Tones. A `ToneSequence` goes through frequencies; a level is a block of one of them, and the phasors of
/// current and commanded voltage are published. As the current keeps its sign in every phase, dead time and
/// threshold are a constant voltage, and the sine sees the impedance of the machine at standstill
///   Z(jω) = R + jω σL_s + jω L R_R/(R_R + jω L),   L = L_m²/L_r,  R_R = (L_m/L_r)² R_r
/// The phasor of the current is that of its readings, and a voltage acts through the period after
/// `actuation_delay_periods` more: both belong to the measurement's evaluation.
///
/// The current follows by a PI controller in the stationary frame, per axis
///   u = K (i* − i) + v,   v[k+1] = v + (R t_period/σL_s)(K (i* − i) + u_real − u)
///   K = 0.2 σL_s/t_period,   R = R_s + k_r² R_r
/// whose zero meets the pole of the machine at standstill. It knows neither the delay nor the inverter: with
/// half the leakage inductance and two periods of delay z³ − z² + 0.4 still has all zeros within the unit
/// circle. While the rotor's EMF decays the current is off by no more than I/(0.2 τ_r/t_period).
///
/// A course begins when torque is enabled, and anew after gates off; behind the last the current is held at
/// zero. The flux is that of the current model: what the machine's voltage tells is the unknown here.
/// Source: the staircase of direct currents of N. Bedetti, S. Calligaro, R. Petrella, "Self-commissioning of
/// inverter dead-time compensation by multiple linear regression based on a physical model", IEEE Trans. Ind.
/// Appl. 51 (2015) 3954–3964; for the impedance at standstill by a sine above a direct current A. Gastli,
/// "Identification of induction motor equivalent circuit parameters using the single-phase test", IEEE Trans.
/// Energy Convers. 14 (1999) 51–56.
template <class T = double>
class CommissioningController final : public EstimatingController<T> {
 public:
  static constexpr const char* name = "commissioning";
  static constexpr const char* meaning =
      "no torque: direct and alternating currents that measure inverter and machine";
  static constexpr T loop_share = T(0.2);  ///< of an error of the current that a period takes away [-]

  static constexpr std::array channels{
      ControlChannel{"level", "1", "levels of current, or blocks of a tone, that are over"},
      ControlChannel{"finished", "1", "1 once every level is over"},
      ControlChannel{"direct_current_a", "A", "reference of the current along phase a"},
      ControlChannel{"level_current_a", "A", "mean reading of the current along phase a, of the last level"},
      ControlChannel{"level_voltage_v", "V", "mean commanded voltage along phase a, of the last level"},
      ControlChannel{"level_link_v", "V", "mean link voltage of the last level"},
      ControlChannel{"level_scatter_a", "A",
                     "standard deviation of the current's readings in the last level"},
      ControlChannel{"level_drift_v", "V",
                     "by how much the voltage rose from half to half of the last level; 0 with a tone"},
      ControlChannel{"level_speed_rad_s", "rad/s", "mean reading of the shaft's speed in the last level"},
      ControlChannel{"tone_periods", "1",
                     "control periods of a cycle of the last level's tone; 0 with a direct current"},
      ControlChannel{"tone_sine_a", "A", "amplitude of the current in phase with the tone's reference"},
      ControlChannel{"tone_cosine_a", "A", "that of the current a quarter of a cycle ahead of it"},
      ControlChannel{"tone_sine_v", "V", "amplitude of the commanded voltage in phase with the reference"},
      ControlChannel{"tone_cosine_v", "V", "that of the commanded voltage a quarter of a cycle ahead of it"}};

  struct Parameters : EstimatingController<T>::Parameters {
    CommissioningCourse course{CommissioningCourse::levels};
    T highest_current{T(20)};             ///< limit of the current [A]
    int levels{4};                        ///< of each sign [-]
    int tones{4};                         ///< frequencies of the sine [-]
    int blocks{4};                        ///< of each tone [-]
    T lowest_frequency{T(9.5)};           ///< of the tones [rad/s]
    T highest_frequency{T(530)};          ///< the same [rad/s]
    std::int64_t settle_ns{735'000'000};  ///< before a level or a tone counts, at least [ns]
    std::int64_t hold_ns{100'000'000};    ///< for which a level or a block counts, at least [ns]

    /// Seven rotor time constants: of a step of the rotor's EMF a thousandth is left. [ns]
    [[nodiscard]] static std::int64_t default_settle_ns(
        const InductionMachineParameters<T>& machine) noexcept {
      return std::llround(T(7e9) * machine.tau_r());
    }
    /// Where the rotor's branch is half resistance and half inductance. [rad/s]
    [[nodiscard]] static T default_lowest_frequency(const InductionMachineParameters<T>& machine) noexcept {
      return T(1) / machine.tau_r();
    }
    /// Where σL_s takes twice the voltage of the resistances; at most a quarter of the bandwidth of the
    /// current's control, so that the amplitude keeps the limit. [rad/s]
    [[nodiscard]] static T default_highest_frequency(const InductionMachineParameters<T>& machine,
                                                     std::int32_t period_ns) noexcept {
      const T corner = (machine.r_s + machine.k_r() * machine.k_r() * machine.r_r) / machine.sigma_l_s();
      return std::min(T(2) * corner, T(0.25) * loop_share / (T(1e-9) * T(period_ns)));
    }
    void set_defaults(const ControlBasis<T>& basis) noexcept {
      EstimatingController<T>::Parameters::set_defaults(basis);
      highest_current = this->magnetiser.current_limit;
      lowest_frequency = default_lowest_frequency(basis.machine);
      highest_frequency = default_highest_frequency(basis.machine, basis.period_ns);
      settle_ns = default_settle_ns(basis.machine);
    }

    friend void describe(Description& d, Parameters& p, const Parameters& by_default) {
      describe(d, p.magnetiser, by_default.magnetiser);
      d.choice("course", p.course,
               {{"levels", CommissioningCourse::levels}, {"tones", CommissioningCourse::tones}},
               "direct currents, for dead time and stator resistance; or sines above a direct current, for "
               "the impedance at standstill");
      d.defaulted("current_limit_a", p.highest_current, p.magnetiser.current_limit,
                  {"A", 0.1, 1e5,
                   "limit of the current; by default magnetising_current_a. Levels go from a fifth of nearly "
                   "all of it up, and sines likewise, of the current of the flux reference where that is "
                   "smaller"});
      d.integer("levels", p.levels, "", 2, 100, "levels of the direct current, of each sign");
      d.integer("tones", p.tones, "", 2, 20, "frequencies of the sine, in equal ratios");
      d.integer("blocks", p.blocks, "", 2, 100, "measurements of each tone");
      describe_times(d, p, by_default);
    }
    static void describe_times(Description& d, Parameters& p, const Parameters& by_default) {
      constexpr double hz = 2.0 * std::numbers::pi;
      constexpr const char* otherwise = "no usable frequency follows from the machine";
      d.defaulted("lowest_tone_hz", {p.lowest_frequency, hz},
                  {p.lowest_frequency, by_default.lowest_frequency},
                  {"Hz", 1e-4, 1e4,
                   "lowest frequency of the sine; by default that of the rotor's time constant, at which the "
                   "rotor tells R_r and L_m"},
                  otherwise);
      d.defaulted("highest_tone_hz", {p.highest_frequency, hz},
                  {p.highest_frequency, by_default.highest_frequency},
                  {"Hz", 1e-4, 1e4,
                   "highest frequency of the sine; by default that at which the leakage inductance takes "
                   "twice the voltage of the resistances, within what the current's control follows"},
                  otherwise);
      d.defaulted_time("settle_ms", p.settle_ns, by_default.settle_ns,
                       in_ms(0.01, 1e6,
                             "time before a level or a tone counts; by default 7 time constants of the "
                             "rotor"));
      d.time("hold_ms", p.hold_ns,
             in_ms(0.01, 1e6, "time for which a level counts, and a block of a tone at least"));
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
      if (tones < 2 || blocks < 2) return "two tones and two blocks of each are needed at least";
      const T period = T(this->period_ns) * T(1e-9);
      if (!(lowest_frequency > T(0) && T(2) * lowest_frequency <= highest_frequency))
        return "the highest tone must have twice the frequency of the lowest at least";
      if (!(lowest_frequency * period * T(most) > turn && highest_frequency * period * T(least_cycle) < turn))
        return "a cycle of a tone must last for 16 control periods at least";
      return nullptr;
    }

   private:
    static constexpr T turn = T(2 * std::numbers::pi);
    static constexpr int least_cycle = 16;  ///< [-]
  };

  explicit CommissioningController(const Parameters& parameters) noexcept
      : Base{prepared(parameters)},
        course_{parameters.course},
        staircase_{staircase(parameters)},
        tones_{tones(parameters)},
        hold_periods_{periods(parameters.hold_ns, parameters.period_ns)},
        level_{hold_periods_},
        gain_{loop_share * parameters.machine.sigma_l_s() / Base::period()},
        integral_share_{pole_share(parameters)} {}

  /// A share of the voltage is of torque, which this controller makes none of.
  [[nodiscard]] bool reaches_six_step() const noexcept override { return true; }

  [[nodiscard]] std::span<const T> channel_values() const noexcept SEXTANT_NONBLOCKING override {
    return values_;
  }

 private:
  using Base = EstimatingController<T>;
  using typename Base::Demand;

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
  /// The lowest current of a tone is that of the lowest level; the highest takes no more flux than the
  /// reference, beyond which iron may saturate.
  [[nodiscard]] static ToneSequence<T> tones(const Parameters& p) noexcept {
    constexpr T lowest = CurrentStaircase<T>::lowest_share;
    const std::int32_t settle = periods(p.settle_ns, p.period_ns);
    const T highest = (T(1) - reserve) * std::min(p.highest_current, p.flux_reference / p.machine.l_s());
    const auto cycle = [&p](T frequency) {
      return periods(std::llround(T(2e9 * std::numbers::pi) / frequency), p.period_ns);
    };
    return ToneSequence<T>{{.bias = T(0.5) * (T(1) + lowest) * highest,
                            .amplitude = T(0.5) * (T(1) - lowest) * highest,
                            .slope = T(10) * highest / T(settle),
                            .tones = std::max(2, p.tones),
                            .blocks = std::max(1, p.blocks),
                            .longest_cycle = cycle(p.lowest_frequency),
                            .shortest_cycle = cycle(p.highest_frequency),
                            .settle_periods = settle,
                            .hold_periods = periods(p.hold_ns, p.period_ns)}};
  }
  /// R t_period/σL_s, at most the whole. [-]
  [[nodiscard]] static T pole_share(const Parameters& p) noexcept {
    const T resistance = p.machine.r_s + p.machine.k_r() * p.machine.k_r() * p.machine.r_r;
    return std::min(T(1), resistance * T(p.period_ns) * T(1e-9) / p.machine.sigma_l_s());
  }

  [[nodiscard]] GatePattern follow(const Demand& demand) noexcept SEXTANT_NONBLOCKING override {
    const bool has_levels = course_ == CommissioningCourse::levels;
    const SpaceVector<T> i = Base::estimator().i_s();
    const T reference = has_levels ? staircase_.step() : tones_.step();
    const SpaceVector<T> proportional = gain_ * (SpaceVector<T>{reference, T(0)} - i);
    const SpaceVector<T> u = proportional + integral_;
    integral_ += integral_share_ * (proportional + Base::realised(u, demand.u_dc) - u);
    const GatePattern pattern = Base::modulate(u, demand.u_dc);
    const T commanded = (T(1) / Base::period()) * volt_seconds(pattern, demand.u_dc).alpha;
    values_[2] = reference;
    if (!has_levels && tones_.holds()) tone_.add(i.alpha, commanded, tones_.phase());
    if (has_levels) {
      measure(staircase_, i.alpha, commanded, demand);
    } else {
      measure(tones_, i.alpha, commanded, demand);
    }
    return pattern;
  }

  /// i [A], commanded u of the coming period [V].
  void measure(const auto& course, T i, T u, const Demand& demand) noexcept {
    values_[1] = course.is_done() ? T(1) : T(0);
    if (!course.holds()) return;
    level_.add(i, u, demand.u_dc, this->estimator().omega_m());
    if (!course.ends_level()) return;
    const bool has_tone = course_ == CommissioningCourse::tones;
    values_ = {T(course.index() + 1),
               values_[1],
               values_[2],
               level_.current(),
               level_.voltage(),
               level_.link(),
               level_.scatter(),
               has_tone ? T(0) : level_.drift(),
               level_.speed(),
               has_tone ? T(tones_.cycle()) : T(0),
               tone_.current().alpha,
               tone_.current().beta,
               tone_.voltage().alpha,
               tone_.voltage().beta};
    begin_level();
  }
  void begin_level() noexcept {
    level_ = LevelMeasurement<T>{hold_periods_};
    tone_ = {};
  }

  void release() noexcept SEXTANT_NONBLOCKING override {
    staircase_.reset();
    tones_.reset();
    begin_level();
    integral_ = {};
    values_ = {};
  }
  void reset_method() noexcept SEXTANT_NONBLOCKING override { release(); }

  CommissioningCourse course_;
  CurrentStaircase<T> staircase_;
  ToneSequence<T> tones_;
  std::int32_t hold_periods_;  ///< [-]
  LevelMeasurement<T> level_;
  ToneMeasurement<T> tone_{};
  T gain_;                                   ///< K [V/A]
  T integral_share_;                         ///< R t_period/σL_s [-]
  SpaceVector<T> integral_{};                ///< v [V]
  std::array<T, channels.size()> values_{};  ///< of the channels
};

}  // namespace sextant
