#pragma once

#include <cstdint>
#include <type_traits>

#include "sextant/core/drive_request.hpp"
#include "sextant/core/gate_pattern.hpp"
#include "sextant/core/measurement.hpp"

namespace sextant {

/// All that enters and leaves the drive in one control period: with it the period can be run again, bit for
/// bit.
template <class T = double>
struct CycleRecord {
  std::int64_t t_ns{};           ///< beginning of the control period, on the drive's clock [ns]
  Measurement<T> measurement{};  ///< as read from the power stage
  DriveRequest<T> request{};
  GatePattern pattern{};  ///< handed to the power stage
};

static_assert(std::is_trivially_copyable_v<CycleRecord<double>>);

}  // namespace sextant
