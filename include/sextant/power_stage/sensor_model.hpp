#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>

#include "sextant/core/description.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/power_stage/converter.hpp"
#include "sextant/power_stage/encoder.hpp"
#include "sextant/power_stage/normal_noise.hpp"
#include "sextant/power_stage/plant_fault.hpp"
#include "sextant/power_stage/resolver.hpp"
#include "sextant/power_stage/sin_cos_encoder.hpp"
#include "sextant/power_stage/temperature_sensor.hpp"

namespace sextant {

/// By how much the current sensor of one phase differs from what is common to all three.
struct PhaseSensorError {
  double gain_error{};  ///< [-]
  double offset{};      ///< [A]
};

/// The sensors of a simulated power stage; ideal by default.
struct SensorParameters {
  ConverterParameters current{};             ///< common to the phases, bipolar [A]
  std::array<PhaseSensorError, 3> phases{};  ///< added to it, of phases a, b, c
  ConverterParameters voltage{};             ///< of the DC link, unipolar [V]
  std::int32_t sampling_lead_ns{};  ///< currents and voltage are sampled so long before a period [ns]
  std::int32_t sampling_skew_ns{};  ///< phase b is sampled so long before c, and a before b [ns]
  EncoderParameters encoder{};
  ResolverParameters resolver{};              ///< in place of an encoder
  SinCosEncoderParameters sin_cos{};          ///< in place of both
  TemperatureSensorParameters temperature{};  ///< of the winding, where it is measured
  std::uint64_t seed{1};                      ///< of the noise [-]

  /// Parameters of the current sensor of phase 0, 1 or 2.
  [[nodiscard]] ConverterParameters current_of(std::size_t phase) const noexcept {
    ConverterParameters p = current;
    p.gain_error += phases[phase].gain_error;
    p.offset += phases[phase].offset;
    return p;
  }

  /// From the sample of phase 0, 1 or 2 to the beginning of the period. [ns]
  [[nodiscard]] std::int32_t lead_of(int phase) const noexcept SEXTANT_NONBLOCKING {
    return sampling_lead_ns + (2 - phase) * sampling_skew_ns;
  }
  /// True where all samples are those of the period's beginning.
  [[nodiscard]] bool samples_at_once() const noexcept SEXTANT_NONBLOCKING {
    return sampling_lead_ns == 0 && sampling_skew_ns == 0;
  }

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    for (std::size_t x = 0; x < 3; ++x) {
      if (const char* problem = current_of(x).validate()) return problem;
    }
    if (const char* problem = voltage.validate()) return problem;
    if (const char* problem = encoder.validate()) return problem;
    if (const char* problem = resolver.validate()) return problem;
    if (const char* problem = sin_cos.validate()) return problem;
    if (const char* problem = temperature.validate()) return problem;
    if (int{encoder.lines > 0} + int{resolver.pole_pairs > 0} + int{sin_cos.periods > 0} > 1)
      return "the shaft has one sensor: only one of encoder.lines, resolver.pole_pairs and sin_cos.periods "
             "may be above 0";
    if (sampling_skew_ns < 0) return "the skew of the samples must not be below zero";
    return sampling_lead_ns >= 0 ? nullptr
                                 : "the sampling instant must not come after the period's beginning";
  }
};

inline constexpr const char* noise_meaning = "standard deviation of the white, normal noise of each reading";

/// Of phase a, b or c, as `table`.
inline void describe(Description& d, const char* table, PhaseSensorError& p) {
  auto& [gain_error, offset] = p;
  d.enter(table);
  d.number("gain_error", gain_error,
           {"", -0.99, 10, "relative error of this phase's gain, added to that of all phases"});
  d.number("offset_a", offset, {"A", -1e5, 1e5, "offset of this phase, added to that of all phases"});
  d.leave();
}

inline void describe_current(Description& d, ConverterParameters& p) {
  auto& [gain_error, offset, noise, range, bits] = p;
  d.number("gain_error", gain_error, {"", -0.99, 10, "relative error of the gain of all phases' sensors"});
  d.number("offset_a", offset, {"A", -1e5, 1e5, "offset of all phases' readings"});
  d.number("noise_a", noise, {"A", 0, 1e5, noise_meaning});
  d.number("range_a", range, {"A", 0, 1e5, "magnitude at which readings saturate; 0: they do not"});
  d.integer("bits", bits, "", 0, 24,
            "resolution of the converter over both signs of range_a; 0: not quantised");
}

inline void describe_voltage(Description& d, ConverterParameters& p) {
  auto& [gain_error, offset, noise, range, bits] = p;
  d.number("gain_error", gain_error, {"", -0.99, 10, "relative error of the sensor's gain"});
  d.number("offset_v", offset, {"V", -2e4, 2e4, "offset of the reading"});
  d.number("noise_v", noise, {"V", 0, 2e4, noise_meaning});
  d.number("range_v", range, {"V", 0, 2e4, "voltage at which readings saturate, also at 0; 0: they do not"});
  d.integer("bits", bits, "", 0, 24, "resolution of the converter over range_v; 0: not quantised");
}

/// lead_of_drive: the sampling lead that the drive counts on, the default of theirs. [ns]
inline void describe(Description& d, SensorParameters& p, const std::int32_t& lead_of_drive) {
  auto& [current, phases, voltage, lead_ns, skew_ns, encoder, resolver, sin_cos, temperature, seed] = p;
  d.integer("seed", seed, "", 0, 1'000'000'000, "of the random noise: the same seed makes the same run");
  d.defaulted_time("sampling_lead_us", lead_ns, lead_of_drive,
                   in_us(0, 1e5,
                         "time before a control period begins at which currents and link voltage are "
                         "sampled; by default as the drive takes it"));
  d.time("sampling_skew_us", skew_ns,
         in_us(0, 5e4,
               "time by which the current of phase b is sampled before that of c, which is sampled with the "
               "link voltage, and that of a before b; the drive takes them as of one instant; 0: they are"));
  d.enter("current");
  describe_current(d, current);
  describe(d, "phase_a", phases[0]);
  describe(d, "phase_b", phases[1]);
  describe(d, "phase_c", phases[2]);
  d.leave();
  d.enter("voltage");
  describe_voltage(d, voltage);
  d.leave();
  d.enter("encoder");
  describe(d, encoder);
  d.leave();
  d.enter("resolver");
  describe(d, resolver);
  d.leave();
  d.enter("sin_cos");
  describe(d, sin_cos);
  d.leave();
  d.enter("temperature");
  describe(d, temperature);
  d.leave();
}

/// Makes of a true measurement what the sensors read: swapped currents and their drift, converters, the
/// shaft's sensor, then the faults that replace a reading. A reading that is kept is that of the last step
/// before the fault.
class SensorModel {
 public:
  /// The parameters must be valid. takes_faults: `set_fault` may follow.
  SensorModel(const SensorParameters& p, const PlantFaultParameters& fault,
              bool takes_faults = false) noexcept
      : current_{Converter{p.current_of(0), true}, Converter{p.current_of(1), true},
                 Converter{p.current_of(2), true}},
        voltage_{p.voltage, false},
        encoder_{p.encoder},
        resolver_{p.resolver},
        sin_cos_{p.sin_cos},
        temperature_{p.temperature},
        noise_{p.seed},
        temperature_noise_{~p.seed},
        fault_{fault},
        is_noisy_{p.current.noise > 0.0 || p.voltage.noise > 0.0},
        is_ideal_{fault.kind == PlantFaultKind::none && !takes_faults && encoder_.is_ideal() &&
                  resolver_.is_ideal() && sin_cos_.is_ideal() && temperature_.is_ideal() &&
                  voltage_.is_ideal() && current_[0].is_ideal() && current_[1].is_ideal() &&
                  current_[2].is_ideal()} {}

  /// True where `step` changes nothing.
  [[nodiscard]] bool is_ideal() const noexcept SEXTANT_NONBLOCKING { return is_ideal_; }

  /// Another fault in place of the one before.
  void set_fault(const PlantFaultParameters& fault) noexcept SEXTANT_NONBLOCKING { fault_ = fault; }

  /// The past of the shaft's sensor: the shaft comes to theta_m [rad], not wrapped, with omega_m [rad/s] at
  /// t_ns, the instant of the first step [ns], and is read every period_ns [ns].
  void begin(double theta_m, double omega_m, std::int64_t t_ns,
             std::int64_t period_ns) noexcept SEXTANT_NONBLOCKING {
    if (!can_count(theta_m) || !can_count(omega_m)) return;
    if (!encoder_.is_ideal()) encoder_.begin(theta_m, omega_m, t_ns, period_ns);
    if (!resolver_.is_ideal()) resolver_.begin(theta_m, omega_m, t_ns);
    if (!sin_cos_.is_ideal()) sin_cos_.begin(theta_m, omega_m, t_ns, period_ns);
  }

  /// A measurement of true values with the shaft at theta_m [rad], not wrapped, at t_ns; fault_ns: the same
  /// instant as the fault counts.
  void step(Measurement<double>& m, double theta_m, std::int64_t t_ns,
            std::int64_t fault_ns) noexcept SEXTANT_NONBLOCKING {
    const PlantFaultKind fault = fault_.kind_at(fault_ns);
    std::array<double, 3> i{m.i_abc.a, m.i_abc.b, m.i_abc.c};
    const auto x = std::size_t(fault_.phase);
    // Exchanged motor cables bring the currents to the sensors of each other's legs.
    if (fault == PlantFaultKind::phases_swapped || fault == PlantFaultKind::cables_swapped)
      std::swap(i[x], i[(x + 1) % 3]);
    if (fault == PlantFaultKind::current_drift)
      i[x] += fault_.drift * double(std::max<std::int64_t>(0, fault_ns - fault_.at_ns)) * 1e-9;
    convert(i, m.u_dc);
    read_winding(m, t_ns);
    read_shaft(m, theta_m, t_ns);
    if (fault == PlantFaultKind::current_stuck) i[x] = last_current_[x];
    if (fault == PlantFaultKind::current_zero) i[x] = 0.0;
    m.i_abc = {i[0], i[1], i[2]};
    replace_others(fault, m);
    last_current_ = i;
    last_ = m;
  }

 private:
  void convert(std::array<double, 3>& i, double& u_dc) noexcept SEXTANT_NONBLOCKING {
    const std::uint64_t n = 4 * step_;
    for (std::size_t x = 0; x < 3; ++x) i[x] = current_[x](i[x], is_noisy_ ? noise_(n + x) : 0.0);
    u_dc = voltage_(u_dc, is_noisy_ ? noise_(n + 3) : 0.0);
  }

  void read_winding(Measurement<double>& m, std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    const std::uint64_t n = step_++;
    if (!m.winding_temperature || temperature_.is_ideal()) [[likely]]
      return;
    const double noise = temperature_.is_noisy() ? temperature_noise_(n) : 0.0;
    m.winding_temperature = temperature_.step(*m.winding_temperature, t_ns, noise);
  }

  /// Of a larger angle, or NaN, edges cannot be counted; nor within a second at a larger speed. [rad, rad/s]
  [[nodiscard]] static bool can_count(double x) noexcept SEXTANT_NONBLOCKING { return std::abs(x) < 1e12; }

  void read_shaft(Measurement<double>& m, double theta_m, std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    if (!can_count(theta_m)) return;
    if (!encoder_.is_ideal()) read(encoder_, m, theta_m, t_ns);
    if (!resolver_.is_ideal()) read(resolver_, m, theta_m, t_ns);
    if (!sin_cos_.is_ideal()) read(sin_cos_, m, theta_m, t_ns);
  }
  template <class ShaftSensor>
  static void read(ShaftSensor& sensor, Measurement<double>& m, double theta_m,
                   std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    sensor.step(theta_m, t_ns);
    m.omega_m = sensor.omega();
    if (m.theta_m) m.theta_m = std::remainder(sensor.theta(), 2.0 * std::numbers::pi);
  }

  void replace_others(PlantFaultKind fault, Measurement<double>& m) const noexcept SEXTANT_NONBLOCKING {
    if (fault == PlantFaultKind::link_stuck) m.u_dc = last_.u_dc;
    if (fault == PlantFaultKind::speed_jump) m.omega_m += fault_.jump;
    if (fault == PlantFaultKind::encoder_reversed) {
      m.omega_m = -m.omega_m;
      if (m.theta_m) m.theta_m = -*m.theta_m;
    }
    if (fault != PlantFaultKind::speed_lost && fault != PlantFaultKind::speed_frozen) return;
    m.omega_m = fault == PlantFaultKind::speed_lost ? 0.0 : last_.omega_m;
    m.theta_m = last_.theta_m;
  }

  std::array<Converter, 3> current_;
  Converter voltage_;
  Encoder encoder_;
  Resolver resolver_;
  SinCosEncoder sin_cos_;
  TemperatureSensor temperature_;
  NormalNoise noise_;
  NormalNoise temperature_noise_;  ///< of another seed: the others' samples stay where they are
  PlantFaultParameters fault_;
  bool is_noisy_;
  bool is_ideal_;
  std::uint64_t step_{};
  std::array<double, 3> last_current_{};  ///< [A]
  Measurement<double> last_{};
};

}  // namespace sextant
