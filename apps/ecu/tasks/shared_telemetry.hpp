#pragma once

#include "ecu/shared/shared_state.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/core/telemetry.hpp"

namespace sextant::ecu {

/// The telemetry sink of the cycle: one record a period into the ring; a full ring drops and counts.
class SharedTelemetry {
 public:
  explicit SharedTelemetry(SharedState& shared) noexcept : shared_{shared} {}

  void push(const Telemetry<double>& telemetry) noexcept SEXTANT_NONBLOCKING {
    last_ = telemetry;
    shared_.telemetry.push(telemetry);
  }
  [[nodiscard]] const Telemetry<double>& last() const noexcept SEXTANT_NONBLOCKING { return last_; }

 private:
  SharedState& shared_;
  Telemetry<double> last_{};
};

}  // namespace sextant::ecu
