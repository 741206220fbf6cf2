#include "sextant/config/direct_torque_config.hpp"

#include "sextant/drive/drive_limits.hpp"

namespace sextant {
namespace {

constexpr Range<double> torque_band_nm{1e-3, 1e5};
constexpr Range<double> current_a{0.1, 1e5};

DriveLimits<> limits_of(const ControlSetup& setup) {
  return drive_limits(setup.machine, setup.flux_reference, setup.u_dc);
}

}  // namespace

void describe(Section s, DirectTorqueController<>::Parameters& p, const ControlSetup& setup) {
  const auto torque_band = [&setup] { return limits_of(setup).torque_band; };
  s.derived("torque_band_upper_nm", p.torque_comparator.upper_band, torque_band_nm, "N·m",
            "band of the upper torque relay", torque_band);
  s.derived("torque_band_lower_nm", p.torque_comparator.lower_band, torque_band_nm, "N·m",
            "band of the lower torque relay, as a magnitude", torque_band);
  s.choice("comparator_reading", p.torque_comparator.reading,
           {{"relay", ComparatorReading::relay}, {"memoryless", ComparatorReading::memoryless}},
           "torque relays with memory, or the band alone");
  s.derived("flux_band_wb", p.flux_comparator.band, {1e-6, 1}, "Wb", "half the width of the flux hysteresis",
            [&setup] { return limits_of(setup).flux_band; });
  s.number("sector_start_deg", p.sector.sector_start_deg, {-180, 180}, "deg",
           "lower edge of sector 1, from voltage vector 1");
  s.derived("magnetising_current_a", p.magnetiser.current_limit, current_a, "A",
            "limit while the flux is built up at standstill",
            [&setup] { return limits_of(setup).magnetising_current; });
  s.derived("hand_over_current_a", p.magnetiser.hand_over_current, current_a, "A",
            "largest current at which torque control follows magnetising",
            [&setup] { return limits_of(setup).hand_over_current; });
  s.flag("flux_priority", p.flux_priority,
         "below the flux band a vector along the flux takes the place of zero vectors, up to "
         "magnetising_current_a");
  s.number("torque_trim_ms", p.torque_trim.time_constant, {0, 1e4}, "ms",
           "time constant with which the mean torque meets its reference; 0: not trimmed", 1e-3);
}

bool trims_mean_torque(const DirectTorqueController<>::Parameters& p) {
  return p.torque_trim.time_constant > 0;
}

}  // namespace sextant
