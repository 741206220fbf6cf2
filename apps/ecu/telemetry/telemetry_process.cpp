#include "ecu/telemetry/telemetry_process.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <spdlog/spdlog.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {
namespace {

/// Time in which a restarted process finds the readers that there are [ns].
constexpr std::int64_t rediscovery_ns = 1'000'000'000;

/// The publisher beside the running program; where there is none, the first on PATH.
std::string default_program() {
  const std::string name = "sextant-telemetry";
  const std::filesystem::path beside = std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
  std::error_code none;
  return std::filesystem::exists(beside, none) ? beside.string() : name;
}

/// Files, signals and scheduling of the new process. Memory locks end with the exec.
class SpawnSettings {
 public:
  /// The descriptors become those from telemetry_process_descriptor on; none of them is one of those.
  explicit SpawnSettings(std::span<const MessageSocket> sockets) {
    posix_spawn_file_actions_init(&files_);
    posix_spawn_file_actions_addopen(&files_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    int next = telemetry_process_descriptor;
    for (const MessageSocket& socket : sockets)
      posix_spawn_file_actions_adddup2(&files_, socket.fd(), next++);
    posix_spawn_file_actions_addclosefrom_np(&files_, next);
    posix_spawnattr_init(&attributes_);
    // A signal to the whole process group, as from a terminal, must not end the publisher before it has
    // published the drive's last state: it ends after the drive.
    sigset_t blocked;
    sigemptyset(&blocked);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&blocked, signal);
    posix_spawnattr_setsigmask(&attributes_, &blocked);
    sigset_t all;
    sigfillset(&all);
    sigdelset(&all, SIGPIPE);  // a closed log does not end the telemetry
    posix_spawnattr_setsigdefault(&attributes_, &all);
    // The CPUs are those of the drive's other threads, without the control thread's.
    const sched_param ordinary{};
    posix_spawnattr_setschedpolicy(&attributes_, SCHED_OTHER);
    posix_spawnattr_setschedparam(&attributes_, &ordinary);
    posix_spawnattr_setflags(&attributes_,
                             POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSCHEDULER);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&files_);
    posix_spawnattr_destroy(&attributes_);
  }

  [[nodiscard]] const posix_spawn_file_actions_t* files() const noexcept { return &files_; }
  [[nodiscard]] const posix_spawnattr_t* attributes() const noexcept { return &attributes_; }

 private:
  posix_spawn_file_actions_t files_{};
  posix_spawnattr_t attributes_{};
};

/// Copies of the publisher's ends above the descriptors that they get in its process.
std::vector<MessageSocket> copies_of(const std::vector<TelemetryConnection>& drives) {
  const int above = telemetry_process_descriptor + int(drives.size());
  std::vector<MessageSocket> copies;
  copies.reserve(drives.size());
  for (const TelemetryConnection& drive : drives) {
    const int copy = fcntl(drive.descriptor(), F_DUPFD_CLOEXEC, above);
    if (copy < 0)
      throw std::system_error(errno, std::system_category(), "a socket for the telemetry cannot be opened");
    copies.emplace_back(copy);
  }
  return copies;
}

std::string ids_of(const std::vector<TelemetryConnection>& drives) {
  std::string ids;
  for (const TelemetryConnection& drive : drives)
    ids += (ids.empty() ? "" : ",") + std::to_string(drive.drive_id());
  return ids;
}

bool crashed(int status) {
  if (!WIFSIGNALED(status)) return false;
  const int signal = WTERMSIG(status);
  return signal == SIGSEGV || signal == SIGBUS || signal == SIGABRT || signal == SIGILL || signal == SIGFPE;
}

std::string describe_end(int status) {
  if (WIFSIGNALED(status))
    return fmt::format("by signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)));
  return fmt::format("with status {}", WEXITSTATUS(status));
}

}  // namespace

TelemetryProcess::TelemetryProcess(const Parameters& parameters, std::vector<TelemetryConnection> drives)
    : parameters_{parameters}, drives_{std::move(drives)} {
  if (parameters_.program.empty()) parameters_.program = default_program();
  start();
  try {
    wait_until_ready();
  } catch (...) {
    leave();
    throw;
  }
}

TelemetryProcess::~TelemetryProcess() {
  leave();
}

void TelemetryProcess::start() {
  each([](TelemetryConnection& drive) { drive.open(); });
  try {
    pid_ = spawn();
  } catch (...) {
    each([](TelemetryConnection& drive) { drive.close(); });
    throw;
  }
  watch_.start();
  killed_ = false;
  started_ns_ = now_ns();
  const StartMessage head{.domain_id = parameters_.domain_id,
                          .configuration_bytes = std::uint32_t(parameters_.configuration.size()),
                          .type_information = type_information_};
  const std::string texts = parameters_.configuration + parameters_.configuration_source;
  each([&](TelemetryConnection& drive) { drive.send_start(head, texts); });
}

pid_t TelemetryProcess::spawn() const {
  const std::vector<MessageSocket> sockets = copies_of(drives_);
  const SpawnSettings settings{sockets};
  std::string name = std::filesystem::path{parameters_.program}.filename().string();
  std::string ids = "--drives=" + ids_of(drives_);
  const std::array<char*, 3> arguments{name.data(), ids.data(), nullptr};
  pid_t pid = 0;
  // It shares the memory until the exec; after a fork every page of the control thread would fault.
  const int error = posix_spawnp(&pid, parameters_.program.c_str(), settings.files(), settings.attributes(),
                                 arguments.data(), environ);
  if (error == 0) return pid;
  throw std::runtime_error(
      fmt::format("{} cannot be started: {}; it publishes the telemetry and belongs "
                  "beside the program of the drive, or on PATH",
                  parameters_.program, std::system_category().message(error)));
}

void TelemetryProcess::wait_until_ready() {
  const std::int64_t end_ns = now_ns() + std::int64_t{ready_within_ms} * 1'000'000;
  bool ended = false;
  while (!ended && !is_ready() && refusal().empty() && now_ns() < end_ns) {
    drives_.front().wait();
    ended = reaped();  // before its last messages are received
    receive_messages();
  }
  if (is_ready()) return;
  if (const std::string why = refusal(); !why.empty()) throw std::runtime_error(why);
  throw std::runtime_error(fmt::format("{} {} before DDS had started", parameters_.program,
                                       pid_ == 0 ? "ended " + describe_end(status_) : "sent no message"));
}

bool TelemetryProcess::is_ready() const noexcept {
  return std::ranges::all_of(drives_, [](const TelemetryConnection& drive) { return drive.is_ready(); });
}

std::string TelemetryProcess::refusal() const {
  for (const TelemetryConnection& drive : drives_) {
    if (!drive.refusal().empty()) return drive.refusal();
  }
  return {};
}

void TelemetryProcess::receive_messages() {
  const bool is_discovering = now_ns() - started_ns_ <= rediscovery_ns;
  each([&](TelemetryConnection& drive) {
    if (drive.receive(is_discovering)) watch_.heard();
  });
}

bool TelemetryProcess::reaped() {
  if (pid_ != 0 && waitpid(pid_, &status_, WNOHANG) == pid_) pid_ = 0;
  return pid_ == 0;
}

void TelemetryProcess::poll(std::int64_t now_ns) {
  if (pid_ == 0) {
    if (now_ns >= restart_ns_) restart(now_ns);
    return;
  }
  const bool was_ready = is_ready();
  const bool ended = reaped();  // before its last messages are received
  receive_messages();
  if (is_ready() && !was_ready) {
    spdlog::info("telemetry: {} publishes again{}", parameters_.program,
                 type_information_ ? "" : ", without type information");
  }
  if (ended) return schedule_restart(now_ns);
  each([](TelemetryConnection& drive) { drive.send_kept(); });
  if (watch_.step(now_ns) && !killed_) kill_stopped();
}

void TelemetryProcess::kill_stopped() {
  spdlog::error("telemetry: {} has sent nothing for {} ms and is killed", parameters_.program,
                watch_.timeout() / 1'000'000);
  kill(pid_, SIGKILL);  // ends a stopped process too
  killed_ = true;
}

void TelemetryProcess::schedule_restart(std::int64_t now_ns) {
  each([](TelemetryConnection& drive) { drive.close(); });
  if (crashed(status_)) type_information_ = false;
  const std::int64_t delay_ns = now_ns - started_ns_ > healthy_ns ? first_delay_ns : delay_ns_;
  delay_ns_ = std::min(2 * delay_ns, last_delay_ns);
  restart_ns_ = now_ns + delay_ns;
  const std::string why = refusal();
  spdlog::error("telemetry: {} ended {}{}; the drive runs on, DDS is started again in {} ms",
                parameters_.program, describe_end(status_), why.empty() ? "" : " (" + why + ")",
                delay_ns / 1'000'000);
}

void TelemetryProcess::restart(std::int64_t now_ns) {
  ++restarts_;
  try {
    start();
  } catch (const std::exception& problem) {
    restart_ns_ = now_ns + last_delay_ns;
    spdlog::error("telemetry: {}; the drive runs on", problem.what());
  }
}

void TelemetryProcess::leave() {
  if (pid_ == 0) return;
  each([](TelemetryConnection& drive) {
    drive.send_kept();
    drive.finish();
  });
  const std::int64_t end_ns = now_ns() + std::int64_t{left_within_ms} * 1'000'000;
  while (!reaped() && now_ns() < end_ns) {
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
    receive_messages();
  }
  receive_messages();
  if (pid_ != 0) {
    spdlog::error("telemetry: {} did not end and was killed", parameters_.program);
    kill(pid_, SIGKILL);
    (void)waitpid(pid_, &status_, 0);
    pid_ = 0;
  }
  each([](TelemetryConnection& drive) { drive.close(); });
}

}  // namespace sextant::ecu
