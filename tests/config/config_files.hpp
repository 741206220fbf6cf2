#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <unistd.h>

#include "sextant/config/config_error.hpp"
#include "sextant/config/load_config.hpp"
#include "support/source_directory.hpp"

namespace sextant {

inline const std::string shipped_ecu = SEXTANT_SOURCE_DIR "/configs/ecu.toml";
inline const std::string shipped_ecu_hil = SEXTANT_SOURCE_DIR "/configs/ecu_hil.toml";
inline const std::string shipped_plant = SEXTANT_SOURCE_DIR "/configs/plant.toml";
inline const std::string shipped_machine = SEXTANT_SOURCE_DIR "/configs/machines/paper_3hp.toml";
inline const std::string shipped_scenario = SEXTANT_SOURCE_DIR "/configs/scenarios/constant_torque.toml";

/// The sentence that refuses a file of sextant-ecu; "accepted" without one.
inline std::string ecu_refusal(const std::string& file, const std::vector<std::string>& overrides = {}) {
  try {
    (void)load_ecu_config(file, overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

/// The same of a scenario.
inline std::string scenario_refusal(const std::vector<std::string>& overrides) {
  try {
    (void)load_scenario_config(shipped_scenario, overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

/// The settings with another value of one key.
inline std::vector<std::string> with(std::vector<std::string> settings, const std::string& key,
                                     const std::string& value) {
  settings.push_back(key + "=" + value);
  return settings;
}

/// A directory of its own for each test, removed with its files.
class ConfigFiles {
 public:
  ConfigFiles() {
    std::string name = (std::filesystem::temp_directory_path() / "sextant_config_XXXXXX").string();
    directory_ = mkdtemp(name.data());
  }
  ConfigFiles(const ConfigFiles&) = delete;
  ConfigFiles& operator=(const ConfigFiles&) = delete;
  ~ConfigFiles() { std::filesystem::remove_all(directory_); }

  /// Writes a file and returns its path.
  [[nodiscard]] std::string write(const std::string& name, const std::string& text) const {
    const std::filesystem::path path = std::filesystem::path{directory_} / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream{path} << text;
    return path.string();
  }

  [[nodiscard]] std::string path(const std::string& name) const { return directory_ + "/" + name; }

 private:
  std::string directory_;
};

}  // namespace sextant
