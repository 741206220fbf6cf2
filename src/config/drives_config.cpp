#include "sextant/config/drives_config.hpp"

#include <cstddef>
#include <filesystem>
#include <string>

namespace sextant {
namespace {

std::string numbered(const char* key, std::size_t first, std::size_t second) {
  return std::string{key} + " is the same for the drives " + std::to_string(first + 1) + " and " +
         std::to_string(second + 1);
}

/// Of two drives.
std::string check_pair(const DrivesConfig& config, std::size_t first, std::size_t second) {
  const EcuConfig& a = config.drives[first];
  const EcuConfig& b = config.drives[second];
  if (a.drive_id == b.drive_id) return numbered("drive_id", first, second) + ": give each drive its own";
  if (a.can.identifier_offset.value == b.can.identifier_offset.value)
    return numbered("can.identifier_offset", first, second) + ": give each drive its own, a multiple of 32";
  if (a.realtime.cpu >= 0 && a.realtime.cpu == b.realtime.cpu)
    return numbered("realtime.cpu", first, second) + ": give each control thread its own";
  if (a.can.bus != b.can.bus)
    return "can.bus differs between the drives of one process: give them one bus, or a process each";
  if (a.dds.domain != b.dds.domain)
    return "dds.domain differs between the drives of one process: give them one domain, or a process each";
  return {};
}

}  // namespace

std::string DrivesConfig::file_of(const std::string& name, std::size_t drive) const {
  if (name.empty() || drives.size() == 1) return name;
  std::filesystem::path path{name};
  path.replace_filename(path.stem().string() + "_" + std::to_string(drives.at(drive).drive_id) +
                        path.extension().string());
  return path.string();
}

void describe(Section root, DrivesConfig& config) {
  root.choice("on_fault", config.on_fault,
              {{"others_go_on", OnFault::others_go_on}, {"all_shut_down", OnFault::all_shut_down}},
              "what the fault of a drive means for the other drives of the process");
}

std::string check_drives(const DrivesConfig& config) {
  if (config.drives.size() > DrivesConfig::most)
    return "a process has at most " + std::to_string(DrivesConfig::most) + " drives, here are " +
           std::to_string(config.drives.size());
  for (std::size_t second = 1; second < config.drives.size(); ++second) {
    for (std::size_t first = 0; first < second; ++first) {
      std::string problem = check_pair(config, first, second);
      if (!problem.empty()) return problem;
    }
  }
  return {};
}

}  // namespace sextant
