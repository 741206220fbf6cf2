#include "sextant/virtual_time/random_bus_events.hpp"

#include <algorithm>
#include <random>
#include <stdexcept>

namespace sextant {
namespace {

/// The engine is the standard's, the same everywhere; its distributions are not, so they are made here.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_{seed} {}

  /// Even from lowest to highest, both included. The bias of the remainder is below 2^-30 for these ranges.
  std::int64_t between(std::int64_t lowest, std::int64_t highest) {
    const auto width = static_cast<std::uint64_t>(highest - lowest) + 1U;
    return lowest + static_cast<std::int64_t>(engine_() % width);
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace

std::vector<BusEvent> draw(const RandomBusEvents& wanted) {
  if (const char* problem = wanted.validate()) throw std::invalid_argument{problem};
  Dice dice{wanted.seed};
  std::vector<BusEvent> events;
  std::int64_t t = wanted.begin_ns;
  while ((t += dice.between(0, 2 * wanted.mean_gap_ns)) < wanted.end_ns) {
    BusEvent event{.kind = wanted.kinds[std::size_t(dice.between(0, std::int64_t(wanted.kinds.size()) - 1))],
                   .begin_ns = t};
    event.end_ns = std::min(t + dice.between(1, wanted.longest_ns), wanted.end_ns);
    event.count = std::uint32_t(dice.between(1, wanted.most_frames));
    event.delay_ns = dice.between(0, wanted.longest_ns);
    event.byte = std::uint8_t(dice.between(0, 7));
    event.mask = std::uint8_t(dice.between(1, 255));
    events.push_back(event);
  }
  return events;
}

}  // namespace sextant
