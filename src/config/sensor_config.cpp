#include "sextant/config/sensor_config.hpp"

#include <sstream>
#include <variant>
#include <vector>

#include "layer.hpp"
#include "printer.hpp"
#include "reader.hpp"

namespace sextant {
namespace {

/// The keys of a fault, without the kind that no request makes. Both are bound by reference.
Schema request_schema(Section (*section_of)(Schema&), PlantFaultParameters& fault, const double& u_dc) {
  Schema schema;
  Section section = section_of(schema);
  describe(section, fault, u_dc);
  section.check(fault);
  for (Field& field : schema.fields) {
    if (auto* choice = std::get_if<ChoiceKind>(&field.kind)) std::erase(choice->names, power_up_fault);
  }
  return schema;
}

}  // namespace

std::string plant_fault_keys() {
  PlantFaultParameters fault;
  const double u_dc = SimulatedDriveIoParameters{}.u_dc;
  return print_keys(request_schema([](Schema& schema) { return Section{schema}; }, fault, u_dc));
}

PlantFaultParameters requested_fault(const std::string& request, const PlantFaultParameters& configured) {
  PlantFaultParameters fault = configured;
  const double u_dc = 2.0 * configured.sag_voltage;  // sag_v that is not given is the configured one
  const auto section_of = [](Schema& schema) { return Section{schema}.section("plant").section("faults"); };
  std::vector<Layer> layers{text_layer("", "--set")};
  std::istringstream lines{request};
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) layers.push_back(override_layer("plant.faults." + line));
  }
  read(request_schema(section_of, fault, u_dc), layers);
  return fault;
}

bool is_ideal(const SimulatedDriveIoParameters& p) {
  return p.dead_time_ns == 0 && p.minimum_pulse.duration_ns == 0 && p.sensors.samples_at_once() &&
         SensorModel{p.sensors, p.fault}.is_ideal();
}

}  // namespace sextant
