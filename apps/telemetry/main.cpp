#include <cstdint>
#include <stdexcept>

#include <CLI/CLI.hpp>

#include "common/program.hpp"
#include "sextant/comms/message_socket.hpp"
#include "sextant/comms/telemetry_messages.hpp"
#include "telemetry/publisher.hpp"

namespace {

constexpr const char* program_name = "sextant-telemetry";

constexpr const char* notes =
    R"(sextant-ecu starts it, sends it the samples and restarts it after its end; it ends with the
drive. DDS runs only in it, so that no failure of DDS affects the drive.)";

int run() {
  constexpr int descriptor = sextant::telemetry_process_descriptor;
  if (!sextant::MessageSocket::is_one(descriptor)) {
    throw std::runtime_error(
        "there is no drive to publish for: start sextant-ecu, which starts this program");
  }
  return sextant::Publisher{sextant::MessageSocket{descriptor}}.run();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Sextant: publishes the telemetry of a live drive over DDS."};
  std::uint32_t drive_id = 1;
  sextant::describe_program(app, program_name, notes);
  app.add_option("--drive", drive_id, "the drive's id, for ps; the drive also sends it");
  CLI11_PARSE(app, argc, argv);
  return sextant::run_program(program_name, 1, [] { return run(); });
}
