#include "sextant/config/direct_torque_config.hpp"

#include <cmath>
#include <string>

#include "number_text.hpp"
#include "shared_control_keys.hpp"

namespace sextant {
namespace {

constexpr Range<double> torque_band_nm{1e-3, 1e5};

/// One vector for one period, from rest, changes the torque by  p ψ_ref u_dc t_period/σL_s,  which is a third
/// of the default limit of torque, 0.4 T_b with T_b = 3/4 p ψ_ref²/σL_s, where the current moves by a
/// fifteenth of ψ_ref/σL_s:
///   (2/3) u_dc t_period/σL_s > ψ_ref/(15 σL_s)
/// Beyond it the table's ripple moves the mean torque of a millisecond off its command by more than the
/// torque monitor allows: on the machines of the library from 200 µs on at high speed, and nowhere up to 175
/// µs. Empty where it is not so, else a sentence.
std::string validate_vector(const ControlSetup& setup) {
  const double leakage = setup.machine.sigma_l_s();
  const double period = setup.period_ns * 1e-9;
  const double step = 2.0 / 3.0 * setup.u_dc * period / leakage;
  const double most = setup.flux_reference / (15 * leakage);
  if (!(step > most)) return {};
  const auto rounded = [](double x) { return number_text(std::round(x * 10) / 10); };
  return "one voltage vector for one control period moves the current by " + rounded(step) +
         " A, more than " + rounded(most) +
         " A, which stands for a third of the torque limit: drive.period_us may be " +
         rounded(std::floor(1e6 * period * most / step)) +
         " us at most with this method; others take shorter vectors";
}

}  // namespace

void describe(Section s, DirectTorqueController<>::Parameters& p, const ControlSetup& setup) {
  const auto defaults = [&setup] { return default_parameters<DirectTorqueController<>>(setup); };
  s.derived(
      "torque_band_upper_nm", p.torque_comparator.upper_band, torque_band_nm, "N·m",
      "torque below its reference beyond which the upper relay raises it, in proportion to flux reference "
      "and link voltage: this one at flux_reference_wb and plant.u_dc_v; the larger, the more ripple and "
      "the less switching",
      [defaults] { return defaults().torque_comparator.upper_band; });
  s.changes(Changes::always);
  s.derived("torque_band_lower_nm", p.torque_comparator.lower_band, torque_band_nm, "N·m",
            "torque above its reference beyond which the lower relay lowers it, in the same proportion",
            [defaults] { return defaults().torque_comparator.lower_band; });
  s.changes(Changes::always);
  s.choice("comparator_reading", p.torque_comparator.reading,
           {{"relay", ComparatorReading::relay}, {"memoryless", ComparatorReading::memoryless}},
           "torque relays that stay on until the error is zero, or only while it is beyond the band");
  s.derived("flux_band_wb", p.flux_comparator.band, {1e-6, 1}, "Wb",
            "half the width of the stator flux's hysteresis: the larger, the more its magnitude ripples and "
            "the less it switches",
            [defaults] { return defaults().flux_comparator.band; });
  s.changes(Changes::always);
  s.number("sector_start_deg", p.sector.sector_start_deg, {-180, 180}, "deg",
           "lower edge of sector 1 of the switching table, from voltage vector 1; -30: symmetrical to the "
           "vectors");
  describe_magnetiser(s, p.magnetiser, setup);
  s.flag("flux_priority", p.flux_priority,
         "whether below the flux band a vector along the flux takes the place of zero vectors, up to "
         "magnetising_current_a");
  s.changes(Changes::always);
  describe_torque_trim(s, p.torque_trim, setup);
  s.check([&setup] { return validate_vector(setup); });
}

}  // namespace sextant
