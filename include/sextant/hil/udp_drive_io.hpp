#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "sextant/hil/datagram_reception.hpp"
#include "sextant/hil/hil_parameters.hpp"
#include "sextant/hil/link_state.hpp"
#include "sextant/hil/linked_drive_io.hpp"
#include "sextant/hil/measurement_assembler.hpp"
#include "sextant/hil/udp_socket.hpp"

namespace sextant {

/// A power stage on another machine, over datagrams in real time. Neither call waits; both make system calls
/// of a socket. Each machine keeps its own clock: a measurement belongs to the drive's time of its reading.
class UdpDriveIo final : public LinkedDriveIo {
 public:
  /// Throws std::runtime_error where the addresses cannot be used.
  UdpDriveIo(const HilParameters& parameters, std::int64_t period_ns);
  ~UdpDriveIo() override;

  [[nodiscard]] Measurement<double> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING override;
  void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override;

  /// Clears the gate-enable line and sends that at once.
  void inhibit_gates() noexcept override;
  void announce_end() noexcept override;
  [[nodiscard]] const LinkState* link_state() const noexcept override { return &state_; }
  [[nodiscard]] std::optional<Counts> counts() const noexcept override {
    return Counts{.measurements = assembler_.counters(),
                  .network = Counts::Network{reception_.counters(), unsent_.load(std::memory_order_relaxed)}};
  }
  [[nodiscard]] const char* loss() const noexcept override { return nullptr; }

 private:
  void discard_what_has_queued_up(MeasurementDatagram& datagram) noexcept SEXTANT_NONBLOCKING;
  void take(const MeasurementDatagram& datagram) noexcept SEXTANT_NONBLOCKING;
  /// Returns the pattern's number.
  std::uint64_t send(const GatePattern& pattern, bool leaving) noexcept SEXTANT_NONBLOCKING;

  UdpSocket socket_;
  std::int64_t period_ns_;
  std::uint32_t generation_;
  DatagramReception reception_;
  MeasurementAssembler assembler_;
  bool started_{false};
  std::atomic<std::int64_t> t_ns_{0};
  std::atomic<std::uint64_t> sequence_;
  std::atomic<std::uint64_t> unsent_{0};
  std::atomic<bool> gates_enabled_{false};
  LinkState state_{};
};

}  // namespace sextant
