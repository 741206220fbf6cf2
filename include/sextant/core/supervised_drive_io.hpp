#pragma once

#include "sextant/core/drive_io.hpp"

namespace sextant {

/// A `DriveIo` with what the other threads of a drive need of the power stage, beside the two calls of the
/// control thread. Each function may be left out.
template <class T = double>
class SupervisedDriveIo : public DriveIo<T> {
 public:
  /// Turns the gates off, also where the control thread hangs; from any thread. The watchdog calls it every
  /// few milliseconds until the control thread goes on.
  virtual void inhibit_gates() noexcept {}

  /// The drive has ended in order; once its control thread has ended.
  virtual void announce_end() noexcept {}

  /// Why the run must end, in a sentence fragment after the power stage's name, as "has lost its FPGA";
  /// nullptr while it can go on. From any thread.
  [[nodiscard]] virtual const char* loss() const noexcept { return nullptr; }
};

}  // namespace sextant
