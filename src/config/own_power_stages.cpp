#include <set>
#include <stdexcept>
#include <string>

#include "bare_key.hpp"
#include "sextant/config/ecu_config.hpp"
#include "sextant/config/own_power_stage.hpp"

namespace sextant {
namespace {

/// The keys and tables at the top of a file of a live drive, and what `power_stage` may be.
std::set<std::string> taken_names() {
  EcuConfig config;
  Schema schema;
  describe(Section{schema}, config);
  std::set<std::string> names{"base", "on_fault"};
  for (const Field& field : schema.fields) {
    names.insert(field.path.substr(0, field.path.find('.')));
    if (field.path != "power_stage") continue;
    const auto& known = std::get<ChoiceField>(field.kind).names;
    names.insert(known.begin(), known.end());
  }
  return names;
}

}  // namespace

OwnPowerStages checked(const OwnPowerStages& own) {
  if (own.empty()) return own;
  std::set<std::string> taken = taken_names();
  for (const auto& power_stage : own) {
    const std::string name = power_stage->name();
    if (is_bare_key(name) && taken.insert(name).second) continue;
    throw std::invalid_argument("the power stage \"" + name +
                                "\" needs another name, of letters, digits, _ and -, that no other power "
                                "stage and no key or table of the file has");
  }
  return own;
}

OwnPowerStages untouched(const OwnPowerStages& power_stages) {
  OwnPowerStages fresh;
  fresh.reserve(power_stages.size());
  for (const auto& power_stage : power_stages) fresh.emplace_back(power_stage->untouched());
  return fresh;
}

}  // namespace sextant
