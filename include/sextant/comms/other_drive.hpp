#pragma once

#include "sextant/comms/can_frame.hpp"
#include "sextant/comms/e2e_profile11.hpp"
#include "sextant/core/identifier_offset.hpp"

namespace sextant {

/// Detects another drive on the bus by a stream of MCU_TorqueStatus whose E2E state is VALID; single frames,
/// replayed or forged, do not suffice. The identifiers do not depend on `drive_id`, and a bus does not return
/// a drive's own frames.
class OtherDrive {
 public:
  explicit OtherDrive(IdentifierOffset offset = {}) noexcept;

  /// Evaluates a received frame; true for a status frame of another drive.
  [[nodiscard]] bool sent(const CanFrame& frame) noexcept;

 private:
  IdentifierOffset offset_;
  E2eChecker checker_;
};

}  // namespace sextant
