#include "sextant/config/moved_keys.hpp"

#include <array>

namespace sextant {
namespace {

constexpr std::array table{
    MovedKey{"control.period_us", "drive.period_us"},
    MovedKey{"plant.actuation_delay_periods", "drive.actuation_delay_periods"},
    MovedKey{"control.torque_band_upper_nm", "control.dtc.torque_band_upper_nm"},
    MovedKey{"control.torque_band_lower_nm", "control.dtc.torque_band_lower_nm"},
    MovedKey{"control.comparator_reading", "control.dtc.comparator_reading"},
    MovedKey{"control.flux_band_wb", "control.dtc.flux_band_wb"},
    MovedKey{"control.sector_start_deg", "control.dtc.sector_start_deg"},
    MovedKey{"control.magnetising_current_a", "control.dtc.magnetising_current_a"},
    MovedKey{"control.hand_over_current_a", "control.dtc.hand_over_current_a"},
    MovedKey{"torque_monitor.current_offset_a", "protection.current_offset_a"},
    MovedKey{"gate", "command"},
    MovedKey{"hil.stale_ms", "hil.measurement_timeout_ms"},
    MovedKey{"hil.silence_ms", "hil.pattern_timeout_ms"},
};

}  // namespace

std::span<const MovedKey> moved_keys() noexcept {
  return table;
}

}  // namespace sextant
