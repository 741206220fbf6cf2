#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "sextant/comms/real_time_sample.hpp"
#include "sextant/core/drive_state.hpp"
#include "sextant/core/fault.hpp"

namespace sextant {

/// A sample of `DriveState` in configs/interfaces/telemetry.idl. The writer adds drive_id and sequence.
struct DriveStateSample {
  std::int64_t t_ns{};  ///< when the state was entered, on the drive's clock [ns]
  DriveState state{DriveState::init};
  bool lockout{true};                  ///< no enable is accepted before a valid disable
  FaultSet faults_active{};            ///< faults present
  FaultSet faults_latched{};           ///< faults since the last reset
  std::optional<Fault> first_fault{};  ///< the first that latched; empty for none
  std::uint32_t fault_total{};         ///< latched faults since start [-]
  std::string_view reason{};           ///< reason of the state, for people; the first 64 bytes are published
};

}  // namespace sextant
