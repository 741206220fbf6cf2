#pragma once

#include <cstdint>

#include "sextant/core/nonblocking.hpp"
#include "sextant/hil/datagram_reception.hpp"
#include "sextant/hil/hil_parameters.hpp"
#include "sextant/hil/link_datagram.hpp"
#include "sextant/hil/udp_socket.hpp"

namespace sextant {

/// The plant's end of a link by datagrams; see SharedMemoryPlantEnd.
class UdpPlantEnd {
 public:
  static constexpr bool same_clock = false;

  /// Throws std::runtime_error where the addresses cannot be used.
  UdpPlantEnd(const HilParameters& parameters, std::int64_t period_ns);

  /// The newest pattern; false when none newer has come since the last call.
  [[nodiscard]] bool take(DrivePatternRecord& command) noexcept SEXTANT_NONBLOCKING;
  [[nodiscard]] bool gates_enabled() const noexcept SEXTANT_NONBLOCKING { return gates_enabled_; }
  [[nodiscard]] bool drive_present() const noexcept SEXTANT_NONBLOCKING { return present_; }
  void publish(MeasurementRecord record) noexcept SEXTANT_NONBLOCKING;

  /// For the thread that calls `take`, or once it has ended.
  [[nodiscard]] const DatagramReception::Counters& network() const noexcept { return reception_.counters(); }
  [[nodiscard]] std::uint64_t unsent() const noexcept { return unsent_; }

 private:
  UdpSocket socket_;
  std::int64_t period_ns_;
  std::uint32_t generation_;
  DatagramReception reception_;
  MeasurementDatagram out_{};
  DrivePatternRecord newest_{};
  std::uint64_t sequence_{0};
  std::uint64_t unsent_{0};
  bool gates_enabled_{false};
  bool present_{false};
};

}  // namespace sextant
