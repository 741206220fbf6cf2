#pragma once

#include <cstdint>
#include <vector>

#include "sextant/virtual_time/bus_event.hpp"

namespace sextant {

/// Parameters of random bus events; one seed gives the same events on every machine.
struct RandomBusEvents {
  std::uint64_t seed{1};                 ///< to be printed with every result [-]
  std::int64_t begin_ns{0};              ///< no event before [ns]
  std::int64_t end_ns{1'000'000'000};    ///< nor after [ns]
  std::int64_t mean_gap_ns{50'000'000};  ///< between the beginnings of two events [ns]
  std::int64_t longest_ns{30'000'000};   ///< of one event [ns]
  std::uint32_t most_frames{3};          ///< affected by one event [-]
  std::vector<BusEventKind> kinds{BusEventKind::lose,      BusEventKind::corrupt, BusEventKind::delay,
                                  BusEventKind::duplicate, BusEventKind::reorder, BusEventKind::burst};

  [[nodiscard]] const char* validate() const noexcept {
    if (end_ns <= begin_ns) return "random bus events must end after their beginning";
    if (mean_gap_ns <= 0 || longest_ns <= 0) return "random bus events need a gap and a length above zero";
    if (most_frames == 0) return "a random bus event must act on one frame at least";
    return kinds.empty() ? "random bus events need a kind" : nullptr;
  }
};

/// Draws the events, in order of time: gaps even between 0 and twice the mean, everything else even as well.
/// Throws std::invalid_argument with the sentence of `validate()`.
[[nodiscard]] std::vector<BusEvent> draw(const RandomBusEvents& wanted);

}  // namespace sextant
