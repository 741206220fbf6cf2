#pragma once

#include <cstdint>

namespace sextant {

/// What ended a piece of an event-exact integration.
enum class EventOutcome : std::uint8_t { reached, event, failed };

/// One piece of an event-exact integration.
struct EventPiece {
  EventOutcome outcome{EventOutcome::failed};
  double duration{};  ///< [s]
  int event{-1};      ///< the event function that fell through zero [-]
};

}  // namespace sextant
