#pragma once

#include <cstdint>

#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/measurement.hpp"
#include "sextant/core/nonblocking.hpp"

namespace sextant {

/// The seam between the drive and the power stage: real hardware, a plant in another process, or the
/// simulated plant in this one. Called once a control period, from the control thread only.
///
/// `Measurement::applied` holds the edges that were commanded, late or lost patterns included. What dead time
/// and drops of the inverter make of them is not in it: hardware does not know the former without a
/// comparator on each leg.
template <class T = double>
class DriveIo {
 public:
  DriveIo() = default;
  DriveIo(const DriveIo&) = delete;
  DriveIo& operator=(const DriveIo&) = delete;
  virtual ~DriveIo() = default;

  /// The measurement at t_ns, the beginning of a control period. A simulated plant is advanced to t_ns
  /// first; over missed periods it behaves as its gate driver. `Measurement::plausible` reports errors.
  [[nodiscard]] virtual Measurement<T> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING = 0;

  /// Writes the pattern of the period that begins at the last read; with an actuation delay of one period,
  /// that of the period after it.
  virtual void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING = 0;
};

}  // namespace sextant
