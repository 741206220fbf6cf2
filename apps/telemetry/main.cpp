#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

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
    R"(sextant-ecu starts it, sends it the samples of its drives and restarts it after its end; it ends
with them. DDS runs only in it, so that no failure of DDS affects a drive.
Example: pgrep -af 'sextant-telemetry --drives=1,2' finds the one of the drives 1 and 2.
)";

int run(bool describes) {
  if (describes) {
    std::fputs(sextant::telemetry_contract_json().c_str(), stdout);
    return sextant::ExitStatus::done;
  }
  std::vector<sextant::MessageSocket> sockets;
  for (int descriptor = sextant::telemetry_process_descriptor; sextant::MessageSocket::is_one(descriptor);
       ++descriptor) {
    sockets.emplace_back(descriptor);
  }
  if (sockets.empty()) {
    throw std::runtime_error(
        "there is no drive to publish for: start sextant-ecu, which starts this program");
  }
  return sextant::Publisher{std::move(sockets)}.run();
}

}  // namespace

int main(int argc, char** argv) {
  std::string drives;
  bool describes = false;
  const std::string help = notes + sextant::exit_status_table();
  const sextant::CommandLine line{program_name,
                                  "Sextant: publishes the telemetry of live drives over DDS.",
                                  help.c_str(),
                                  {{.name = "--drives",
                                    .value = &drives,
                                    .what = "the ids of the drives, for ps: each drive sends its own too",
                                    .type_name = "ID,ID"},
                                   {.name = "--describe",
                                    .value = &describes,
                                    .what = "print topics, members and enumerators as JSON and exit"}}};
  if (const std::optional<int> status = line.parse(argc, argv)) return *status;
  return sextant::run_program(program_name, [&] { return run(describes); });
}
