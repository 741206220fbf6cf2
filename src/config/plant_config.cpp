#include "sextant/config/plant_config.hpp"

#include <string>

#include "drive_sections.hpp"

namespace sextant {
namespace {

void share(PlantConfig& c) {
  InductionMachineParameters<>& machine = c.plant.plant.machine;
  machine = apply(c.machine, machine, c.machine.reactance_frequency_hz.value_or(50.0));
  c.plant.io.period_ns = c.period_ns;
  c.plant.io.load_origin_ns.reset();
}

std::string check_pacing(const PlantConfig& c) {
  if (c.hil.pacing == Pacing::lockstep) {
    if (c.transport == PlantTransport::udp) {
      return "pacing = \"lockstep\" needs transport = \"shared_memory\": datagrams get lost";
    }
    return {};
  }
  if (c.realtime.wake_every_periods > 1) {
    return "a plant in real time runs each period in its time: realtime.wake_every_periods must be 1";
  }
  if (c.plant.io.actuation_delay_periods != 1) {
    return "in real time a pattern acts one period after the measurement that it answers: "
           "drive.actuation_delay_periods must be 1";
  }
  return {};
}

/// A plant in lockstep waits for its drive, not for a deadline.
std::string check_wake_period(const PlantConfig& c) {
  if (c.hil.pacing == Pacing::lockstep) return {};
  return sentence(c.realtime.validate(c.period_ns));
}

}  // namespace

void describe(Section root, PlantConfig& c) {
  root.choice("transport", c.transport,
              {{"shared_memory", PlantTransport::shared_memory}, {"udp", PlantTransport::udp}},
              "link to the drive: on this machine, or over a network");
  root.time("period_us", c.period_ns, in_us(1, 1e5, "plant period; the drive's control period"));
  root.section("drive").integer("actuation_delay_periods", c.plant.io.actuation_delay_periods, "", 0, 1,
                                "control periods between the drive's decision and its pattern");
  describe(root.section_or_file("machine"), c.machine);
  root.derive([&c] { share(c); });
  static constexpr std::int32_t no_lead = 0;
  describe_plant(root, c.plant, c.load, no_lead);
  Section hil = root.section("hil");
  describe_parameters(hil, c.hil);
  hil.check([&c] { return check_pacing(c); });
  Section realtime = root.section("realtime");
  describe_parameters(realtime, c.realtime);
  realtime.check([&c] { return check_wake_period(c); });
}

}  // namespace sextant
