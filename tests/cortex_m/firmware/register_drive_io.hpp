#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <utility>

#include "sextant/core/drive_io.hpp"

namespace sextant::firmware {

/// Injected results of an analogue-digital converter that the timer starts in the middle of a period.
/// Source: ST, RM0090 (STM32F405), 13.13: ADC_JDR1…4 at 0x3C of ADC1.
struct CurrentConverter {
  volatile std::uint32_t result[4];  ///< currents of phases a, b, c and the link voltage, 12 bits each
  static CurrentConverter& instance() { return *reinterpret_cast<CurrentConverter*>(0x4001'203CU); }
};

/// The timer that makes the six gate signals. Source: RM0090, 17.4: TIM1_CCR1…4 and TIM1_BDTR.
struct GateTimer {
  volatile std::uint32_t compare[4];  ///< of phases a, b, c; preloaded, act from the next period on
  volatile std::uint32_t break_and_dead_time;
  static constexpr std::uint32_t main_output_enable = 1U << 15U;
  static GateTimer& instance() { return *reinterpret_cast<GateTimer*>(0x4001'0034U); }
};

/// The timer that counts an encoder's edges. Source: RM0090, 18.4: TIM3_CNT.
struct EncoderTimer {
  volatile std::uint32_t count;
  static EncoderTimer& instance() { return *reinterpret_cast<EncoderTimer*>(0x4000'0424U); }
};

/// A three-phase inverter on the registers of a microcontroller, one switching state a period, which acts one
/// period after it was written: shunts or Hall sensors, a divider on the link, an encoder on the shaft.
class RegisterDriveIo final : public DriveIo<float> {
 public:
  struct Parameters {
    std::int32_t period_ns{25'000};            ///< control period [ns]
    float ampere_per_count{500.0F / 4096.0F};  ///< of the current sensors [A]
    float zero_current_count{2048.0F};         ///< where they show no current [-]
    float volt_per_count{800.0F / 4096.0F};    ///< of the link's divider [V]
    float edges_per_turn{16'384.0F};           ///< of the encoder, all four edges of a line [-]
    std::uint32_t full_duty{4201};             ///< compare value that is never reached: always high [-]
  };

  explicit RegisterDriveIo(const Parameters& parameters) noexcept
      : parameters_{parameters},
        speed_per_edge_{
            2.0F * std::numbers::pi_v<float> /
            (parameters.edges_per_turn * float(speed_periods) * float(parameters.period_ns) * 1e-9F)} {}

  [[nodiscard]] Measurement<float> read(std::int64_t /*t_ns*/) noexcept override {
    const CurrentConverter& adc = CurrentConverter::instance();
    return {.i_abc = {current(adc.result[0]), current(adc.result[1]), current(adc.result[2])},
            .u_dc = parameters_.volt_per_count * float(adc.result[3]),
            .omega_m = speed(),
            .applied = std::exchange(acting_, next_)};
  }

  void write(const GatePattern& pattern) noexcept override {
    next_ = pattern;
    const SwitchState state = pattern.last_state();
    GateTimer& timer = GateTimer::instance();
    // Three legs open together, as they do in every pattern of direct torque control.
    if (!is_driven(state)) {
      timer.break_and_dead_time = timer.break_and_dead_time & ~GateTimer::main_output_enable;
      return;
    }
    for (unsigned leg = 0; leg < 3; ++leg) {
      timer.compare[leg] = (state.upper_switches() >> leg & 1U) * parameters_.full_duty;
    }
    timer.break_and_dead_time = timer.break_and_dead_time | GateTimer::main_output_enable;
  }

 private:
  static constexpr unsigned speed_periods = 32;  // over which the edges are counted

  [[nodiscard]] float current(std::uint32_t count) const noexcept {
    return parameters_.ampere_per_count * (float(count) - parameters_.zero_current_count);
  }

  /// Mean over the last `speed_periods`: within a single period hardly an edge comes.
  [[nodiscard]] float speed() noexcept {
    const auto now = std::uint16_t(EncoderTimer::instance().count);
    const auto edges = std::int16_t(std::uint16_t(now - counts_[at_]));
    counts_[at_] = now;
    at_ = (at_ + 1U) % speed_periods;
    return speed_per_edge_ * float(edges);
  }

  Parameters parameters_;
  float speed_per_edge_;  ///< [rad/s]
  std::array<std::uint16_t, speed_periods> counts_{};
  unsigned at_{0};
  GatePattern acting_{};  ///< over the present period
  GatePattern next_{};    ///< over the coming one
};

}  // namespace sextant::firmware
