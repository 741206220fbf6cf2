#include "ecu/telemetry/dds_settings.hpp"

#include "loopback_configuration.hpp"

namespace sextant::ecu {
namespace {

constexpr const char* leaves_in_time =
    "<CycloneDDS><Domain><Internal><HeartbeatInterval min=\"2 ms\" minsched=\"5 ms\">10 "
    "ms</HeartbeatInterval>"
    "<WriterLingerDuration>30 ms</WriterLingerDuration></Internal></Domain></CycloneDDS>";

DdsSettings chosen(const DdsConfig& config, const char* environment) {
  if (!config.config_uri.empty())
    return {config.config_uri, "dds.config_uri = \"" + config.config_uri + "\""};
  if (environment == nullptr) return {loopback_configuration, "configs/cyclonedds_loopback.xml, the default"};
  return {environment, "the environment, CYCLONEDDS_URI=" + std::string{environment}};
}

}  // namespace

DdsSettings dds_settings(const DdsConfig& config, const char* environment) {
  DdsSettings settings = chosen(config, environment);
  const std::string given = settings.configuration.empty() ? "" : "," + settings.configuration;
  settings.configuration = leaves_in_time + given;
  return settings;
}

}  // namespace sextant::ecu
