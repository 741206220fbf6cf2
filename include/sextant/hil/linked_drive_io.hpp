#pragma once

#include <cstdint>
#include <optional>

#include "sextant/core/supervised_drive_io.hpp"
#include "sextant/hil/datagram_reception.hpp"
#include "sextant/hil/link_state.hpp"
#include "sextant/hil/measurement_assembler.hpp"

namespace sextant {

/// A power stage behind a link to a plant in another process, with what the other threads of a drive need of
/// the link. `inhibit_gates()` clears the gate-enable line; without effect on a plant that waits for the
/// drive. `loss()` is that of such a plant.
class LinkedDriveIo : public SupervisedDriveIo<double> {
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

  /// State of a plant in real time; nullptr for one that waits for the drive. From any thread.
  [[nodiscard]] virtual const LinkState* link_state() const noexcept = 0;

  /// Counts of a plant in real time; for the thread that reads, or once it has ended.
  [[nodiscard]] virtual std::optional<Counts> counts() const noexcept = 0;
};

}  // namespace sextant
