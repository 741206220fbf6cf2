#pragma once

#include <cstdint>
#include <limits>

#include "sextant/core/nonblocking.hpp"
#include "sextant/core/space_vector.hpp"
#include "sextant/core/telemetry.hpp"
#include "sextant/core/telemetry_record.hpp"

namespace sextant {

/// Reduces the telemetry of consecutive control periods to one record: mean, minimum and maximum of torque,
/// flux and current, the mean of the DC-link quantities, and the last period's value of everything else.
/// Table-based DTC swings by several N·m within a millisecond, so a single sample of it says little.
///
/// Every period weighs the same. A NaN makes the mean NaN and leaves minimum and maximum to the numbers.
template <class T = double>
class TelemetryInterval {
 public:
  void add(const Telemetry<T>& x) noexcept SEXTANT_NONBLOCKING {
    ++count_;
    const T weight = T(1) / T(count_);
    torque_.add(x.torque, weight);
    flux_.add(x.psi_s_magnitude, weight);
    current_.add(magnitude(clarke(x.i_abc)), weight);
    u_dc_ += weight * (x.u_dc - u_dc_);
    i_dc_ += weight * (x.i_dc - i_dc_);
    power_ += weight * (x.u_dc * x.i_dc - power_);
    last_ = x;
  }

  /// The interval so far. Without any period `periods` is zero and so is every value.
  [[nodiscard]] TelemetryIntervalRecord<T> record() const noexcept SEXTANT_NONBLOCKING {
    if (count_ == 0) return {};
    return {.t_ns = last_.t_ns,
            .periods = count_,
            .torque_requested_nm = last_.torque_requested,
            .torque_reference_nm = last_.torque_reference,
            .torque_mean_nm = torque_.mean,
            .torque_min_nm = torque_.lowest(),
            .torque_max_nm = torque_.highest(),
            .flux_mean_wb = flux_.mean,
            .flux_min_wb = flux_.lowest(),
            .flux_max_wb = flux_.highest(),
            .current_mean_a = current_.mean,
            .current_min_a = current_.lowest(),
            .current_max_a = current_.highest(),
            .i_a_a = last_.i_abc.a,
            .i_b_a = last_.i_abc.b,
            .i_c_a = last_.i_abc.c,
            .flux_angle_rad = angle(last_.psi_s),
            .speed_rad_s = last_.omega_m,
            .u_dc_v = u_dc_,
            .i_dc_a = i_dc_,
            .power_w = power_,
            .state = last_.state,
            .sector = last_.sector,
            .command_counter = last_.command_counter,
            .command_received_ns = last_.command_received_ns,
            .derating_cause = std::uint8_t(last_.derating_cause)};
  }

  /// Begins the next interval.
  void reset() noexcept SEXTANT_NONBLOCKING { *this = {}; }

  /// Control periods added since the last reset. [-]
  [[nodiscard]] std::uint32_t count() const noexcept SEXTANT_NONBLOCKING { return count_; }

 private:
  struct Envelope {
    T mean{};
    T min{std::numeric_limits<T>::infinity()};
    T max{-std::numeric_limits<T>::infinity()};

    void add(T x, T weight) noexcept {
      mean += weight * (x - mean);
      if (x < min) min = x;
      if (x > max) max = x;
    }
    // Infinite limits are left only where no value was a number.
    [[nodiscard]] T lowest() const noexcept { return min > max ? std::numeric_limits<T>::quiet_NaN() : min; }
    [[nodiscard]] T highest() const noexcept { return min > max ? std::numeric_limits<T>::quiet_NaN() : max; }
  };

  Envelope torque_{};
  Envelope flux_{};
  Envelope current_{};
  T u_dc_{};
  T i_dc_{};
  T power_{};
  Telemetry<T> last_{};
  std::uint32_t count_{0};
};

}  // namespace sextant
