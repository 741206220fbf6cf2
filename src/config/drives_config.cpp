#include "sextant/config/drives_config.hpp"

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>

namespace sextant {
namespace {

std::string the_same(const char* key, std::size_t first, std::size_t last) {
  return std::string{key} + " is the same in the tables " + std::to_string(first + 1) + " and " +
         std::to_string(last + 1);
}

/// Keys of which each drive has its own.
std::string shared_key(const DrivesConfig& config, std::size_t first, std::size_t last) {
  const EcuConfig& a = config.drives[first];
  const EcuConfig& b = config.drives[last];
  if (a.drive_id == b.drive_id) return the_same("drive_id", first, last) + ": give each drive its own";
  if (a.can.identifier_offset.value == b.can.identifier_offset.value)
    return the_same("can.identifier_offset", first, last) + ": give each drive its own, a multiple of 32";
  if (a.realtime.cpu >= 0 && a.realtime.cpu == b.realtime.cpu)
    return the_same("realtime.cpu", first, last) + ": give each control thread its own";
  if (a.power_stage != b.power_stage) return {};
  if (a.power_stage_kind() == PowerStageKind::shared_memory && a.hil.link == b.hil.link)
    return the_same("hil.link", first, last) + ": give each drive a plant of its own";
  if (a.power_stage_kind() == PowerStageKind::udp && a.hil.udp_listen == b.hil.udp_listen)
    return the_same("hil.udp_listen", first, last) + ": give each drive a plant of its own";
  return {};
}

/// Keys that the drives of a process have in common.
std::string other_key(const EcuConfig& a, const EcuConfig& b) {
  if (a.can.bus != b.can.bus)
    return "can.bus differs between the drives of one process: give them one bus, or a process each";
  if (a.dds.domain != b.dds.domain)
    return "dds.domain differs between the drives of one process: give them one domain, or a process each";
  if (a.dds.config_uri != b.dds.config_uri)
    return "dds.config_uri differs between the drives of one process: give them one, or a process each";
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
  root.choice(
      "on_fault", config.on_fault,
      {{"others_go_on", OnFault::others_go_on}, {"all_shut_down", OnFault::all_shut_down}},
      "what the fault of a drive means for the other drives of the process: nothing, or that every drive "
      "ramps its torque to zero and the process ends");
  root.list<EcuConfig>("drive", config.drives, [](Section s, EcuConfig& c) { describe(std::move(s), c); });
}

std::string check_last_drive(const DrivesConfig& config) {
  if (config.drives.size() > DrivesConfig::most)
    return "a process has at most " + std::to_string(DrivesConfig::most) + " drives";
  const std::size_t last = config.drives.size() - 1;
  for (std::size_t first = 0; first < last; ++first) {
    if (std::string problem = shared_key(config, first, last); !problem.empty()) return problem;
    if (std::string problem = other_key(config.drives[first], config.drives[last]); !problem.empty())
      return problem;
  }
  return {};
}

}  // namespace sextant
