#pragma once

#include <atomic>
#include <cstdint>

#include "sextant/core/drive_io.hpp"
#include "sextant/hil/datagram_reception.hpp"
#include "sextant/hil/hil_parameters.hpp"
#include "sextant/hil/link_state.hpp"
#include "sextant/hil/measurement_assembler.hpp"
#include "sextant/hil/udp_socket.hpp"

namespace sextant {

/// A power stage on another machine, met by datagrams in real time. Neither call waits; both make system
/// calls of a socket. Each machine keeps its own clock: a measurement gets the drive's time at which it was
/// read.
class UdpDriveIo final : public DriveIo<double> {
 public:
  /// Throws std::runtime_error where the addresses cannot be had.
  UdpDriveIo(const HilParameters& parameters, std::int64_t period_ns);
  ~UdpDriveIo() override;

  [[nodiscard]] Measurement<double> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING override;
  void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override;

  /// Takes the gate-enable line away and says so at once; from any thread.
  void open_gates() noexcept;

  /// Says that the drive leaves in order; once its control thread has ended.
  void say_goodbye() noexcept;

  /// What the drive knows of the plant; from any thread.
  [[nodiscard]] const LinkState& state() const noexcept { return state_; }

  /// For the thread that reads, or once it has ended.
  [[nodiscard]] const MeasurementAssembler::Counters& counters() const noexcept {
    return assembler_.counters();
  }
  [[nodiscard]] const DatagramReception::Counters& network() const noexcept { return reception_.counters(); }
  [[nodiscard]] std::uint64_t unsent() const noexcept { return unsent_.load(std::memory_order_relaxed); }

 private:
  void discard_what_has_queued_up(MeasurementDatagram& datagram) noexcept SEXTANT_NONBLOCKING;
  void take(const MeasurementDatagram& datagram) noexcept SEXTANT_NONBLOCKING;
  /// Returns the command's number.
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
