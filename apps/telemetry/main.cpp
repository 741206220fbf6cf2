#include <cstdint>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>

#include "common/command_line.hpp"
#include "common/exit_status.hpp"
#include "common/program.hpp"
#include "sextant/comms/message_socket.hpp"
#include "sextant/comms/telemetry_messages.hpp"
#include "telemetry/contract_json.hpp"
#include "telemetry/publisher.hpp"

namespace {

constexpr const char* program_name = "sextant-telemetry";

constexpr const char* notes =
    R"(sextant-ecu starts it, sends it the samples and restarts it after its end; it ends with the
drive. DDS runs only in it, so that no failure of DDS affects the drive.
Example: pgrep -af 'sextant-telemetry --drive 1' finds the one of drive 1.
)";

int run(bool describes) {
  if (describes) {
    std::fputs(sextant::telemetry_contract_json().c_str(), stdout);
    return sextant::ExitStatus::done;
  }
  constexpr int descriptor = sextant::telemetry_process_descriptor;
  if (!sextant::MessageSocket::is_one(descriptor)) {
    throw std::runtime_error(
        "there is no drive to publish for: start sextant-ecu, which starts this program");
  }
  return sextant::Publisher{sextant::MessageSocket{descriptor}}.run();
}

}  // namespace

int main(int argc, char** argv) {
  std::uint32_t drive_id = 1;
  bool describes = false;
  const std::string help = notes + sextant::exit_status_table();
  const sextant::CommandLine line{
      program_name,
      "Sextant: publishes the telemetry of a live drive over DDS.",
      help.c_str(),
      {{.name = "--drive", .value = &drive_id, .what = "the drive's id, for ps: the drive sends it too"},
       {.name = "--describe",
        .value = &describes,
        .what = "print topics, members and enumerators as JSON and exit"}}};
  if (const std::optional<int> status = line.parse(argc, argv)) return *status;
  return sextant::run_program(program_name, [&] { return run(describes); });
}
