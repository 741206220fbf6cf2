#include "ecu/parameters/load_drives.hpp"

#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "sextant/config/drive_override.hpp"

namespace sextant::ecu {
namespace {

void require_same_drives(const DrivesConfig& again, const DrivesConfig& running) {
  if (again.drives.size() != running.drives.size()) {
    throw std::runtime_error{
        fmt::format("the configuration file is another one than at the start (drives from {} to {}): restore "
                    "it, or start the drives anew",
                    running.drives.size(), again.drives.size())};
  }
}

/// A drive of a configuration that has been read again.
EcuConfig one_of(const DrivesConfig& again, std::size_t drive, const DrivesConfig& running) {
  if (again.on_fault != running.on_fault)
    throw std::runtime_error{"on_fault never changes while the drives run: start them anew with --set"};
  return again.drives[drive];
}

}  // namespace

ParameterChanges::Load load_of(LoadDrives load, std::size_t drive, const DrivesConfig& running) {
  return [load = std::move(load), drive, &running](const std::vector<std::string>& overrides) {
    std::vector<std::string> own;
    own.reserve(overrides.size());
    for (const std::string& text : overrides) own.push_back(for_drive(running.drives[drive].drive_id, text));
    require_same_drives(load({}), running);
    return one_of(load(own), drive, running);
  };
}

}  // namespace sextant::ecu
