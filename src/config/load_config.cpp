#include "sextant/config/load_config.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "layer.hpp"
#include "printer.hpp"
#include "reader.hpp"
#include "sextant/config/drive_override.hpp"
#include "sextant/config/key_change.hpp"

namespace sextant {
namespace {

template <class Config>
Schema schema_of(Config& config) {
  Schema schema;
  describe(Section{schema}, config);
  return schema;
}

constexpr const char* drive_tables = "drive";  // the list in a file of several drives

void require_one_drive(const Layer& file) {
  const toml::node* const found = file.table.get(drive_tables);
  if (found == nullptr || !found->is_array()) return;
  throw ConfigError{{file.problem(
      found, drive_tables, "a list of drives, where the file of one is expected; sextant-ecu runs several")}};
}

/// Reads into a configuration that has its control methods.
template <class Config>
Config load(Layer file, const std::vector<std::string>& overrides, Config config) {
  std::vector<Layer> layers;
  layers.push_back(std::move(file));
  insert_base_layers(layers);
  for (const Layer& layer : layers) require_one_drive(layer);
  for (const std::string& text : overrides) layers.push_back(override_layer(text));
  const Schema schema = schema_of(config);
  for (const std::string& table : schema.files) insert_section_layer(layers, table);
  read(schema, layers);
  return config;
}

template <class Config>
Config with_methods(const ControlMethods& own) {
  Config config;
  config.drive.methods = with_own(std::move(config.drive.methods), own);
  return config;
}

EcuConfig load_ecu(Layer layer, const std::vector<std::string>& overrides, const EcuExtensions& own) {
  auto config = with_methods<EcuConfig>(own.methods);
  config.own_power_stages = checked(own.power_stages);
  return load(std::move(layer), overrides, std::move(config));
}

/// The keys of a file of several drives that count for the process: those of the file without its drives, and
/// those of the overrides, which are taken out.
DrivesConfig load_process(Layer file, std::vector<DriveOverride>& overrides) {
  DrivesConfig config;
  const Schema schema = schema_of(config);
  std::vector<Layer> layers;
  layers.push_back(std::move(file));
  std::erase_if(overrides, [&](const DriveOverride& given) {
    Layer layer = override_layer(given.text);
    const bool is_own = std::ranges::any_of(
        schema.fields, [&layer](const Field& field) { return layer.find(field.path) != nullptr; });
    if (is_own) layers.push_back(std::move(layer));
    return is_own;
  });
  read(schema, layers);
  return config;
}

/// The drive_id of a file with its bases and overrides, before anything else of it is read.
int drive_id_of(const Layer& file, const std::vector<DriveOverride>& overrides) {
  constexpr const char* key = "drive_id";
  std::vector<Layer> layers{file};
  insert_base_layers(layers);
  for (const DriveOverride& given : overrides) {
    if (!given.drive_id) layers.push_back(override_layer(given.text));
  }
  std::int64_t id = EcuConfig{}.drive_id;
  for (const Layer& layer : layers) {
    if (const toml::node* const found = layer.find(key)) id = found->value_or(id);
  }
  return int(id);
}

/// A drive of a process. id: by which overrides name it.
EcuConfig load_drive(Layer layer, int id, const std::vector<DriveOverride>& overrides,
                     const EcuExtensions& own) {
  std::vector<std::string> texts;
  for (const DriveOverride& given : overrides) {
    if (given.counts_for(id)) texts.push_back(given.text);
  }
  return load_ecu(std::move(layer), texts, own);
}

/// Throws where an override is for a drive that is not there. ids: of the drives, as overrides name them.
void require_drives(const std::vector<DriveOverride>& overrides, const std::vector<int>& ids) {
  std::string known;
  for (const int id : ids) known += (known.empty() ? "" : ", ") + std::to_string(id);
  for (const DriveOverride& given : overrides) {
    if (std::ranges::any_of(ids, [&given](int id) { return given.counts_for(id); })) continue;
    throw ConfigError{{{"--set", 0, for_drive(given.drive_id.value_or(0), given.text),
                        "no drive has this drive_id; there is " + known}}};
  }
}

/// Of the same kind, before a file has been read.
template <class Config>
Config untouched_config(const Config& config) {
  Config fresh;
  if constexpr (requires { config.drive.methods; }) fresh.drive.methods = untouched(config.drive.methods);
  if constexpr (requires { config.own_power_stages; })
    fresh.own_power_stages = untouched(config.own_power_stages);
  if constexpr (requires { config.drives; }) {
    for (const EcuConfig& drive : config.drives) fresh.drives.push_back(untouched_config(drive));
  }
  return fresh;
}

template <class Config>
std::string printed(Config config) {
  Config defaults = untouched_config(config);
  return print(schema_of(config), schema_of(defaults));
}

template <class Config>
std::string json_of(Config config) {
  return print_json(schema_of(config));
}

}  // namespace

EcuConfig load_ecu_config(const std::string& file, const std::vector<std::string>& overrides,
                          const EcuExtensions& own) {
  return load_ecu(read_layer(file), overrides, own);
}

EcuConfig load_ecu_config_text(const std::string& text, const std::string& name,
                               const std::vector<std::string>& overrides, const EcuExtensions& own) {
  return load_ecu(text_layer(text, name), overrides, own);
}

DrivesConfig load_drives_config(const std::string& file, const std::vector<std::string>& overrides,
                                const EcuExtensions& own) {
  Layer layer = read_layer(file);
  std::vector<DriveOverride> given;
  given.reserve(overrides.size());
  for (const std::string& text : overrides) given.push_back(drive_override(text));
  const toml::node* const found = layer.table.get(drive_tables);
  if (found == nullptr || !found->is_array()) {
    const int id = drive_id_of(layer, given);
    require_drives(given, {id});
    return {.drives = {load_drive(std::move(layer), id, given, own)}};
  }
  if (!found->is_array_of_tables())
    throw ConfigError{{layer.problem(found, drive_tables, "expected [[drive]] tables, one to eight")}};
  toml::array tables = std::move(*layer.table.get(drive_tables)->as_array());
  layer.table.erase(drive_tables);
  const std::vector<DriveOverride> all = given;
  std::vector<int> ids;
  DrivesConfig config = load_process(std::move(layer), given);
  for (toml::node& table : tables) {
    const auto line = static_cast<int>(table.source().begin.line);
    Layer drive{file, "", false, std::move(*table.as_table())};
    ids.push_back(drive_id_of(drive, given));
    config.drives.push_back(load_drive(std::move(drive), ids.back(), given, own));
    if (std::string problem = check_last_drive(config); !problem.empty())
      throw ConfigError{{{file, line, drive_tables, std::move(problem)}}};
  }
  require_drives(all, ids);
  return config;
}

PlantConfig load_plant_config(const std::string& file, const std::vector<std::string>& overrides) {
  return load(read_layer(file), overrides, PlantConfig{});
}

ScenarioConfig load_scenario_config(const std::string& file, const std::vector<std::string>& overrides,
                                    const ControlMethods& own) {
  return load(read_layer(file), overrides, with_methods<ScenarioConfig>(own));
}

std::string print_config(const EcuConfig& config) {
  return printed(config);
}
std::string print_config(const DrivesConfig& config) {
  if (config.drives.size() == 1) return print_config(config.drives.front());
  return printed(config);
}
std::string print_config(const PlantConfig& config) {
  return printed(config);
}
std::string print_config(const ScenarioConfig& config) {
  return printed(config);
}

std::string config_json(const EcuConfig& config) {
  return json_of(config);
}
std::string config_json(const PlantConfig& config) {
  return json_of(config);
}
std::string config_json(const ScenarioConfig& config) {
  return json_of(config);
}

std::string running_keys(const EcuConfig& config) {
  EcuConfig copy{config};
  return print_running(schema_of(copy));
}

std::vector<KeyChange> key_changes(const EcuConfig& before, const EcuConfig& after) {
  EcuConfig from{before};
  EcuConfig to{after};
  const Schema of_from = schema_of(from);
  const Schema of_to = schema_of(to);
  std::vector<KeyChange> changes;
  for (std::size_t k = 0; k < of_from.lists.size(); ++k) {
    const std::size_t size = of_from.lists[k].size();
    const std::size_t other = of_to.lists[k].size();
    if (size == other) continue;
    changes.push_back({of_from.lists[k].path, Changes::never, std::to_string(size) + " tables",
                       std::to_string(other) + " tables"});
  }
  if (!changes.empty()) return changes;
  const std::vector<Field> fields = expanded(of_from).fields;
  const std::vector<Field> others = expanded(of_to).fields;
  for (std::size_t k = 0; k < fields.size(); ++k) {
    std::string value = value_text(fields[k]);
    std::string other = value_text(others[k]);
    if (value == other) continue;
    changes.push_back({fields[k].path, fields[k].changes, std::move(value), std::move(other)});
  }
  return changes;
}

}  // namespace sextant
