#include "sextant/hil/udp_drive_io.hpp"

#include <cstddef>
#include <span>

#include "clock.hpp"

namespace sextant {

UdpDriveIo::UdpDriveIo(const HilParameters& parameters, std::int64_t period_ns)
    : socket_{parameters.udp_listen, parameters.udp_peer},
      period_ns_{period_ns},
      generation_{random_generation()},
      reception_{DatagramKind::measurement, period_ns, parameters.measurement_timeout_ns},
      assembler_{assembler_parameters(parameters, period_ns)},
      // Numbers differ between starts, so that a plant acknowledges patterns of this start only.
      sequence_{std::uint64_t{generation_} << 32U} {}

UdpDriveIo::~UdpDriveIo() {
  announce_end();
}

void UdpDriveIo::announce_end() noexcept {
  gates_enabled_.store(false, std::memory_order_release);
  // Three, because datagrams may be lost; without any the drive times out.
  for (int n = 0; n < 3; ++n) send({}, true);
}

Measurement<double> UdpDriveIo::read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
  t_ns_.store(t_ns, std::memory_order_relaxed);
  MeasurementDatagram datagram;
  if (!started_) discard_what_has_queued_up(datagram);
  // Bounded in time during a flood; the rest is read in the next period.
  for (int n = 0; n < UdpSocket::more_than_it_keeps; ++n) {
    const std::size_t size = socket_.receive(std::as_writable_bytes(std::span{&datagram, 1}));
    if (size == 0) break;
    if (!reception_.accept(datagram.header, size, sizeof datagram, clock_ns())) continue;
    if (is_of_its_header(datagram))
      take(datagram);
    else
      reception_.count_malformed();
  }
  const Measurement<double> m = assembler_.take(t_ns);
  state_.publish(assembler_);
  return m;
}

/// Discards the datagrams that the kernel queued between the socket's opening and the first period.
void UdpDriveIo::discard_what_has_queued_up(MeasurementDatagram& datagram) noexcept SEXTANT_NONBLOCKING {
  started_ = true;
  for (int n = 0; n < UdpSocket::more_than_it_keeps; ++n) {
    if (socket_.receive(std::as_writable_bytes(std::span{&datagram, 1})) == 0) return;
  }
}

void UdpDriveIo::take(const MeasurementDatagram& datagram) noexcept SEXTANT_NONBLOCKING {
  const std::size_t count = datagram.header.count;
  for (std::size_t n = count; n-- > 0;) {
    const MeasurementRecord& record = datagram.records[n];
    const MeasurementRecord& newest = assembler_.newest();
    const bool is_new_plant = record.generation != newest.generation;
    // Of a new plant only the newest record counts.
    if (is_new_plant && n > 0) continue;
    if (is_new_plant || record.sequence > newest.sequence) assembler_.add(record);
  }
}

void UdpDriveIo::write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING {
  const bool is_off = all_gates_off(pattern);
  assembler_.wrote(send(pattern, false), !is_off);
  // A cleared line is set only with gates off.
  if (is_off) gates_enabled_.store(true, std::memory_order_release);
}

void UdpDriveIo::inhibit_gates() noexcept {
  gates_enabled_.store(false, std::memory_order_release);
  send({}, false);
}

std::uint64_t UdpDriveIo::send(const GatePattern& pattern, bool leaving) noexcept SEXTANT_NONBLOCKING {
  // A pattern with a later number than that of inhibit_gates() carries the cleared line.
  const std::uint64_t sequence = sequence_.fetch_add(1, std::memory_order_acq_rel) + 1;
  CommandDatagram d;
  d.header.kind = std::uint16_t(DatagramKind::pattern);
  d.header.sequence = sequence;
  d.header.sent_ns = clock_ns();
  d.header.period_ns = period_ns_;
  d.header.generation = generation_;
  d.header.count = 1;
  d.command = {sequence, t_ns_.load(std::memory_order_relaxed), to_record(pattern), generation_, 1};
  d.gate_enable = gates_enabled_.load(std::memory_order_acquire) ? 1U : 0U;
  d.leaving = leaving ? 1U : 0U;
  if (!socket_.send(std::as_bytes(std::span{&d, 1}))) unsent_.fetch_add(1, std::memory_order_relaxed);
  return sequence;
}

}  // namespace sextant
