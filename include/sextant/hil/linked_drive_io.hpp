#pragma once

#include <cstdint>
#include <optional>

#include "sextant/core/drive_io.hpp"
#include "sextant/hil/datagram_reception.hpp"
#include "sextant/hil/link_state.hpp"
#include "sextant/hil/measurement_assembler.hpp"

namespace sextant {

/// A power stage behind a link to a plant in another process. Beside the two calls of the control thread it
/// has what the other threads of a drive need of a link.
class LinkedDriveIo : public DriveIo<double> {
 public:
  /// Counts of a link in real time, for people.
  struct Counts {
    /// Of a link over a network.
    struct Network {
      DatagramReception::Counters received{};
      std::uint64_t unsent{};  ///< datagrams that could not be sent [-]
    };
    MeasurementAssembler::Counters measurements{};
    std::optional<Network> network{};
  };

  /// Clears the gate-enable line; from any thread. Without effect on a plant that waits for the drive.
  virtual void inhibit_gates() noexcept = 0;

  /// Announces the orderly end of the drive; once its control thread has ended.
  virtual void announce_end() noexcept = 0;

  /// State of a plant in real time; nullptr for one that waits for the drive. From any thread.
  [[nodiscard]] virtual const LinkState* link_state() const noexcept = 0;

  /// Counts of a plant in real time; for the thread that reads, or once it has ended.
  [[nodiscard]] virtual std::optional<Counts> counts() const noexcept = 0;

  /// Why the run must end, in a sentence fragment after the plant's name; nullptr while it can go on. From
  /// any thread.
  [[nodiscard]] virtual const char* loss() const noexcept = 0;
};

}  // namespace sextant
