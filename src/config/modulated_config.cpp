#include "sextant/config/modulated_config.hpp"

#include <utility>

#include "shared_control_keys.hpp"

namespace sextant {
namespace {

void describe_modulated(Section s, ModulatedController<>::Parameters& p, const ControlSetup& setup) {
  describe_magnetiser(s, p.magnetiser, setup);
  s.choice(
      "pattern", p.modulator.pattern,
      {{"symmetric", PatternKind::symmetric}, {"asymmetric", PatternKind::asymmetric}},
      "each modulated leg switches twice a period, about its middle; or once, which halves the switching "
      "frequency");
  s.choice(
      "zero_vectors", p.modulator.zero_vectors,
      {{"both", ZeroVectors::both},
       {"low", ZeroVectors::low},
       {"high", ZeroVectors::high},
       {"alternating", ZeroVectors::alternating}},
      "both for the same time; V0 or V7 alone; or the one with which the leg of the largest voltage does "
      "not switch; another share of both where a pulse would be too short");
  s.choice("overmodulation", p.modulator.overmodulation,
           {{"magnitude", Overmodulation::magnitude},
            {"angle", Overmodulation::angle},
            {"fundamental", Overmodulation::fundamental}},
           "in the place of a voltage beyond the inverter's hexagon the nearest one, up to six-step, or the "
           "one in the same direction; or from u_dc/sqrt(3) on those of which it is the fundamental, up to "
           "six-step, for capability.voltage_use above 1");
  s.time("shortest_pulse_us", p.modulator.shortest_pulse_ns, 1e3, {0, 1000}, "us",
         "shortest time for which a leg is high, or low, in a period; a shorter one is left out or "
         "lengthened where no share of the zero vectors avoids it; what the inverter needs follows from "
         "drive.inverter.minimum_pulse_us by itself");
}

constexpr const char* bandwidth_of_torque_and_flux =
    "bandwidth with which torque and stator flux follow their references; by default 0.2, at most 0.5, "
    "divided "
    "by the control period";

void describe_bandwidth(Section& s, double& bandwidth, const ControlSetup& setup, const char* what) {
  s.derived("bandwidth_rad_s", bandwidth, {1, 1e6}, "rad/s", what,
            [&setup] { return default_bandwidth<double>(setup.period_ns); });
  s.changes(Changes::always);
}

}  // namespace

void describe(Section s, DeadbeatController<>::Parameters& p, const ControlSetup& setup) {
  describe_modulated(std::move(s), p, setup);
}

void describe(Section s, FieldOrientedController<>::Parameters& p, const ControlSetup& setup) {
  describe_bandwidth(s, p.bandwidth, setup,
                     "bandwidth with which the current follows its reference; by default 0.2, at most 0.5, "
                     "divided by the control period");
  describe_modulated(std::move(s), p, setup);
}

void describe(Section s, FeedbackLinearisationController<>::Parameters& p, const ControlSetup& setup) {
  describe_bandwidth(s, p.bandwidth, setup, bandwidth_of_torque_and_flux);
  describe_modulated(std::move(s), p, setup);
}

void describe(Section s, PwmDtcController<>::Parameters& p, const ControlSetup& setup) {
  describe_bandwidth(s, p.bandwidth, setup, bandwidth_of_torque_and_flux);
  describe_modulated(std::move(s), p, setup);
}

}  // namespace sextant
