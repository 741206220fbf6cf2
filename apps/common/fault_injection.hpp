#pragma once

#include <string>

#include "common/injected_faults.hpp"
#include "sextant/core/drive_io.hpp"
#include "sextant/hil/request_socket.hpp"
#include "sextant/power_stage/faultable_drive_io.hpp"
#include "sextant/power_stage/plant_fault.hpp"

namespace sextant {

/// Faults of the simulated plant by requests on a local socket, while it runs. A request has a line for each
/// key of [plant.faults] that it gives, `key=value` as after --set; the others are those of the
/// configuration. The reply is "ok", or a sentence that says what is wrong. The request `describe` has the
/// keys and kinds as its reply (`plant_fault_keys`). Swapped motor cables stay as
/// they are from power-up on: no request makes them, and where the configuration has them none is taken.
class FaultInjection {
 public:
  /// configured: the fault of the configuration. The power stage is not owned and must outlive this object.
  /// log_prefix: of its lines in the log. Throws as RequestSocket.
  FaultInjection(const std::string& socket, FaultableDriveIo& io, const PlantFaultParameters& configured,
                 std::string log_prefix = {});

  /// The power stage with its faults.
  [[nodiscard]] DriveIo<double>& io() noexcept { return io_; }

  /// Takes the request that waits; one thread calls it.
  void poll() { socket_.poll(); }

 private:
  [[nodiscard]] std::string answer(const std::string& request);

  InjectedFaults io_;
  PlantFaultParameters configured_;
  std::string log_prefix_;
  RequestSocket socket_;
};

}  // namespace sextant
