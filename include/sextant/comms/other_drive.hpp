#pragma once

#include "sextant/comms/can_frame.hpp"
#include "sextant/comms/e2e_profile11.hpp"
#include "sextant/core/identifier_offset.hpp"

namespace sextant {

/// Notices another drive with the same identifiers: they belong to one drive of a bus, whatever its
/// `drive_id` is, and a bus does not hand a drive's own frames back to it. What counts is a stream of
/// MCU_TorqueStatus that is valid end to end; single frames, replayed or made up, are not enough.
class OtherDrive {
 public:
  explicit OtherDrive(IdentifierOffset offset = {}) noexcept;

  /// Takes a frame of the bus; true for one by which another drive is known.
  [[nodiscard]] bool sent(const CanFrame& frame) noexcept;

 private:
  IdentifierOffset offset_;
  E2eChecker checker_;
};

}  // namespace sextant
