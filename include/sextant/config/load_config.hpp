#pragma once

#include <string>
#include <vector>

#include "sextant/config/config_error.hpp"
#include "sextant/config/drives_config.hpp"
#include "sextant/config/ecu_config.hpp"
#include "sextant/config/ecu_extensions.hpp"
#include "sextant/config/plant_config.hpp"
#include "sextant/config/scenario_config.hpp"

namespace sextant {

/// Reads a TOML file. `base = "path"` names a file of the same kind, relative to the file that names it,
/// whose keys this file changes; a base has none of its own. `machine = "path"` (or `machine.file`) names a
/// machine file in the same way; keys of [machine] change it. So does a scenario name its vehicle.
/// `overrides` are "key=value" with a dotted key and a TOML value, where bare words count as strings; they
/// come last, and a file they name is relative to the working directory. `own`: control methods and power
/// stages that a program brings beside Sextant's. Throws ConfigError with every problem found.
[[nodiscard]] EcuConfig load_ecu_config(const std::string& file,
                                        const std::vector<std::string>& overrides = {},
                                        const EcuExtensions& own = {});
/// The same from a text as print_config makes it; `name` stands for the file in messages.
[[nodiscard]] EcuConfig load_ecu_config_text(const std::string& text, const std::string& name,
                                             const std::vector<std::string>& overrides = {},
                                             const EcuExtensions& own = {});
/// The drives of a process: the one of the file or, of a file of `[[drive]]` tables, one for each table. Such
/// a table is a configuration of its own, as a rule with a `base`; overrides count for every drive.
[[nodiscard]] DrivesConfig load_drives_config(const std::string& file,
                                              const std::vector<std::string>& overrides = {},
                                              const EcuExtensions& own = {});
[[nodiscard]] PlantConfig load_plant_config(const std::string& file,
                                            const std::vector<std::string>& overrides = {});
[[nodiscard]] ScenarioConfig load_scenario_config(const std::string& file,
                                                  const std::vector<std::string>& overrides = {},
                                                  const ControlMethods& own = {});

/// The configuration in force as a file that can be read back: every key with its value, unit, range, default
/// and meaning. Optional keys that are not set are comments.
[[nodiscard]] std::string print_config(const EcuConfig& config);
/// Of several drives as a file of `[[drive]]` tables.
[[nodiscard]] std::string print_config(const DrivesConfig& config);
[[nodiscard]] std::string print_config(const PlantConfig& config);
[[nodiscard]] std::string print_config(const ScenarioConfig& config);

/// The configuration in force as one JSON object, from the dotted keys of `--set` to their values.
[[nodiscard]] std::string config_json(const EcuConfig& config);
[[nodiscard]] std::string config_json(const PlantConfig& config);
[[nodiscard]] std::string config_json(const ScenarioConfig& config);

/// The keys of a running drive as a JSON list: objects of `key`, `unit`, `meaning`, `changes`, `value` and,
/// where the key has them, `choices`, or `least` and `most`.
[[nodiscard]] std::string running_keys(const EcuConfig& config);

}  // namespace sextant
