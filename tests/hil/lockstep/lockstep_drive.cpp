// A whole drive in lockstep with sextant-plant, as a process: runs a scenario's torque steps through command
// gate, state machine and controller, prints the real-time factor and a digest of every period's telemetry.
// lockstep_drive <ecu configuration> <link> <seconds of virtual time> [key=value …]
#include <bit>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "sextant/config/load_config.hpp"
#include "sextant/config/make_controller.hpp"
#include "sextant/drive/run_cycle.hpp"
#include "sextant/hil/lockstep_drive_io.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace {

/// FNV-1a over the bits of what a drive reports.
class Digest {
 public:
  void push(const sextant::Telemetry<double>& t) noexcept {
    for (const double x : {t.torque, t.torque_reference, t.psi_s_magnitude, t.i_abc.a, t.i_abc.b, t.i_abc.c,
                           t.omega_m, t.i_dc}) {
      add(std::bit_cast<std::uint64_t>(x));
    }
    add(std::uint64_t(t.t_ns));
    add(std::uint64_t(t.state) << 32U ^ t.latched.bits());
    last_ = t;
  }
  [[nodiscard]] std::uint64_t value() const noexcept { return value_; }
  [[nodiscard]] const sextant::Telemetry<double>& last() const noexcept { return last_; }

 private:
  void add(std::uint64_t word) noexcept {
    for (int n = 0; n < 8; ++n) value_ = (value_ ^ (word >> (8 * n) & 0xFFU)) * 0x100000001B3U;
  }
  std::uint64_t value_{0xCBF29CE484222325U};
  sextant::Telemetry<double> last_{};
};

/// Disable, then enable, and a torque that changes its sign every 100 ms.
class Steps {
 public:
  [[nodiscard]] sextant::DriveRequest<double> latest(std::int64_t t_ns) noexcept {
    constexpr std::int64_t every_ns = 100'000'000;
    sextant::DriveRequest<double> request;
    request.command.enable = t_ns > 5'000'000;
    request.command.torque = t_ns / every_ns % 2 == 0 ? 15.0 : -15.0;
    request.command.received_ns = t_ns;
    request.command.torque_limit = 150.0;
    request.command.sequence = std::uint64_t(t_ns / 10'000'000 + 1);
    request.command.e2e = sextant::E2eState::valid;
    return request;
  }
};

int run(const std::vector<std::string>& arguments) {
  std::vector<std::string> settings{arguments.begin() + 4, arguments.end()};
  settings.push_back("hil.link=\"" + arguments[2] + "\"");
  const sextant::EcuConfig config = sextant::load_ecu_config(arguments[1], settings);
  const std::int64_t period_ns = config.drive.drive.period_ns;
  sextant::SharedMemoryLink link{config.hil, sextant::LinkRole::drive, period_ns};
  sextant::LockstepDriveIo io{link, config.hil.lockstep_timeout_ns};
  const auto controller = sextant::make_controller(config.drive);
  sextant::Drive<double> drive{config.drive.drive, *controller};
  Steps steps;
  Digest digest;
  const auto periods = std::int64_t(std::stod(arguments[3]) * 1e9) / period_ns;
  sextant::run_cycle(0, io, steps, drive, digest);  // the plant has come
  const std::int64_t begin_ns = sextant::now_ns();
  for (std::int64_t k = 1; k < periods && !io.lost(); ++k) {
    sextant::run_cycle(k * period_ns, io, steps, drive, digest);
  }
  const double wall_s = double(sextant::now_ns() - begin_ns) * 1e-9;
  if (io.lost()) {
    std::fprintf(stderr, "lockstep_drive: the plant is lost\n");
    return 1;
  }
  std::printf("periods %lld\nwall_s %.6f\nreal_time_factor %.3f\nus_per_period %.3f\n",
              static_cast<long long>(periods), wall_s, double(periods * period_ns) * 1e-9 / wall_s,
              wall_s * 1e6 / double(periods));
  std::printf("state %s\ntorque_nm %.3f\ndigest %016llx\n", to_string(digest.last().state),
              digest.last().torque, static_cast<unsigned long long>(digest.value()));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc < 4) {
      std::fputs(
          "lockstep_drive: usage: lockstep_drive <ecu configuration> <link> <seconds> [key=value ...]\n",
          stderr);
      return 2;
    }
    return run({argv, argv + argc});
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "lockstep_drive: %s\n", problem.what());
    return 1;
  }
}
