#include "sextant/hil/udp_plant_end.hpp"

#include <algorithm>
#include <cstddef>
#include <span>

#include "clock.hpp"

namespace sextant {

UdpPlantEnd::UdpPlantEnd(const HilParameters& parameters, std::int64_t period_ns)
    : socket_{parameters.udp_listen, parameters.udp_peer},
      period_ns_{period_ns},
      generation_{random_generation()},
      reception_{DatagramKind::pattern, period_ns, parameters.pattern_timeout_ns} {}

bool UdpPlantEnd::take(DrivePatternRecord& command) noexcept SEXTANT_NONBLOCKING {
  // With a full queue the kernel may have dropped the newest patterns, and with a queue that is not empty
  // newer ones wait: the pattern read last is then out of date.
  constexpr int most_without_loss = 64;
  bool fresh = false;
  CommandDatagram d;
  int read = 0;
  for (; read < UdpSocket::more_than_it_keeps; ++read) {
    const std::size_t size = socket_.receive(std::as_writable_bytes(std::span{&d, 1}));
    if (size == 0) break;
    if (!reception_.accept(d.header, size, sizeof d, clock_ns())) continue;
    if (!is_of_its_header(d)) {
      reception_.count_malformed();
      continue;
    }
    const bool is_new_drive = d.command.generation != newest_.generation;
    if (!is_new_drive && d.command.sequence <= newest_.sequence) continue;  // overtaken on the way
    newest_ = d.command;
    gates_enabled_ = d.gate_enable != 0;
    present_ = d.leaving == 0;
    fresh = true;
  }
  if (!fresh || read > most_without_loss) return false;
  command = newest_;
  return true;
}

void UdpPlantEnd::publish(MeasurementRecord record) noexcept SEXTANT_NONBLOCKING {
  record.generation = generation_;
  record.sequence = ++sequence_;
  std::shift_right(out_.records.begin(), out_.records.end(), 1);
  out_.records[0] = record;
  out_.header.kind = std::uint16_t(DatagramKind::measurement);
  out_.header.sequence = sequence_;
  out_.header.sent_ns = clock_ns();
  out_.header.period_ns = period_ns_;
  out_.header.generation = generation_;
  out_.header.count = std::uint32_t(std::min<std::uint64_t>(sequence_, MeasurementDatagram::capacity));
  if (!socket_.send(std::as_bytes(std::span{&out_, 1}))) ++unsent_;
}

}  // namespace sextant
