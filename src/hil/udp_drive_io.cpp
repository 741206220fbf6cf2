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
      // No start has the numbers of another: what a plant has taken is this drive's, or is not.
      sequence_{std::uint64_t{generation_} << 32U} {}

UdpDriveIo::~UdpDriveIo() {
  say_goodbye();
}

void UdpDriveIo::say_goodbye() noexcept {
  gates_enabled_.store(false, std::memory_order_release);
  // One of them may get lost; without any the plant notices the silence.
  for (int n = 0; n < 3; ++n) send({}, true);
}

Measurement<double> UdpDriveIo::read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
  t_ns_.store(t_ns, std::memory_order_relaxed);
  MeasurementDatagram datagram;
  if (!started_) discard_what_has_queued_up(datagram);
  // Bounded, so that a flood takes bounded time; what is left waits for the next period.
  for (int n = 0; n < UdpSocket::more_than_it_keeps; ++n) {
    const std::size_t size = socket_.receive(std::as_writable_bytes(std::span{&datagram, 1}));
    if (size == 0) break;
    if (reception_.accept(datagram.header, size, sizeof datagram, clock_ns())) take(datagram);
  }
  const Measurement<double> m = assembler_.take(t_ns);
  state_.publish(assembler_);
  return m;
}

/// From the opening of the socket to the first period the kernel keeps what it has room for.
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
    // Of a plant that has only just come, the newest: what was before the drive does not matter.
    if (is_new_plant && n > 0) continue;
    if (is_new_plant || record.sequence > newest.sequence) assembler_.add(record);
  }
}

void UdpDriveIo::write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING {
  const bool open = all_gates_off(pattern);
  assembler_.wrote(send(pattern, false), !open);
  // Once taken away, the line comes back with gates off only.
  if (open) gates_enabled_.store(true, std::memory_order_release);
}

void UdpDriveIo::open_gates() noexcept {
  gates_enabled_.store(false, std::memory_order_release);
  send({}, false);
}

std::uint64_t UdpDriveIo::send(const GatePattern& pattern, bool leaving) noexcept SEXTANT_NONBLOCKING {
  // A pattern with a later number than that of open_gates() has seen the line taken away.
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
