#include "ecu/telemetry/telemetry_process.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string_view>
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
  explicit SpawnSettings(int descriptor) {
    posix_spawn_file_actions_init(&files_);
    posix_spawn_file_actions_addopen(&files_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&files_, descriptor, telemetry_process_descriptor);
    posix_spawn_file_actions_addclosefrom_np(&files_, telemetry_process_descriptor + 1);
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

std::vector<std::byte> start_message(const TelemetryProcess::Parameters& parameters, bool type_information) {
  StartMessage head{.domain_id = parameters.domain_id,
                    .drive_id = parameters.drive_id,
                    .configuration_bytes = std::uint32_t(parameters.configuration.size()),
                    .type_information = type_information};
  const std::string texts = parameters.configuration + parameters.configuration_source;
  std::vector<std::byte> message(sizeof head + texts.size());
  std::memcpy(message.data(), &head, sizeof head);
  std::memcpy(message.data() + sizeof head, texts.data(), texts.size());
  return message;
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

TelemetryProcess::TelemetryProcess(const Parameters& parameters) : parameters_{parameters} {
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
  auto [own, its] = MessageSocket::pair();
  pid_ = spawn(its.fd());
  its_end_ = std::move(its);
  watch_.start();
  ready_ = false;
  killed_ = false;
  refusal_.clear();
  counts_ = {};
  started_ns_ = now_ns();
  (void)own.send(start_message(parameters_, type_information_));
  sender_.connect(std::move(own));
}

pid_t TelemetryProcess::spawn(int descriptor) const {
  const SpawnSettings settings{descriptor};
  std::string name = std::filesystem::path{parameters_.program}.filename().string();
  std::string drive = fmt::format("--drive={}", parameters_.drive_id);
  const std::array<char*, 3> arguments{name.data(), drive.data(), nullptr};
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
  while (!ended && !ready_ && refusal_.empty() && now_ns() < end_ns) {
    (void)sender_.socket().wait(std::chrono::milliseconds{100});
    ended = reaped();  // before its last messages are received
    receive_messages();
  }
  if (ready_) return;
  if (!refusal_.empty()) throw std::runtime_error(refusal_);
  throw std::runtime_error(fmt::format("{} {} before DDS had started", parameters_.program,
                                       pid_ == 0 ? "ended " + describe_end(status_) : "sent no message"));
}

void TelemetryProcess::receive_messages() {
  std::array<std::byte, 4096> buffer{};
  while (const auto message = sender_.socket().receive(buffer)) {
    if (message->empty()) return;
    watch_.heard();
    handle(*message);
  }
}

void TelemetryProcess::handle(std::span<const std::byte> message) {
  const auto kind = kind_of(message);
  if (kind == TelemetryMessageKind::ready) ready_ = true;
  if (kind == TelemetryMessageKind::refused) refusal_ = text_after<AnswerMessage>(message);
  if (kind == TelemetryMessageKind::counts) {
    counts_ = content_of<CountsMessage>(message).value_or(counts_);
    const bool is_read = counts_.waveform_readers > 0;
    if (is_read || now_ns() - started_ns_ > rediscovery_ns) sender_.set_waveform_is_read(is_read);
  }
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
  const bool was_ready = ready_;
  const bool ended = reaped();  // before its last messages are received
  receive_messages();
  if (ready_ && !was_ready) {
    spdlog::info("telemetry: {} publishes again{}", parameters_.program,
                 type_information_ ? "" : ", without type information");
  }
  if (ended) return schedule_restart(now_ns);
  sender_.send_kept();
  if (watch_.step(now_ns) && !killed_) kill_stopped();
}

void TelemetryProcess::kill_stopped() {
  spdlog::error("telemetry: {} has sent nothing for {} ms and is killed", parameters_.program,
                watch_.timeout() / 1'000'000);
  kill(pid_, SIGKILL);  // ends a stopped process too
  killed_ = true;
}

void TelemetryProcess::close_connection() {
  std::array<std::byte, sizeof(WaveformMessage)> buffer{};
  while (const auto message = its_end_.receive(buffer)) {
    if (message->empty()) break;
    sender_.count_lost(*message);
  }
  sender_.disconnect();
  const MessageSocket closed = std::move(its_end_);
}

void TelemetryProcess::schedule_restart(std::int64_t now_ns) {
  close_connection();
  earlier_ = counts();
  counts_ = {};
  if (crashed(status_)) type_information_ = false;
  const std::int64_t delay_ns = now_ns - started_ns_ > healthy_ns ? first_delay_ns : delay_ns_;
  delay_ns_ = std::min(2 * delay_ns, last_delay_ns);
  restart_ns_ = now_ns + delay_ns;
  spdlog::error("telemetry: {} ended {}{}; the drive runs on, DDS is started again in {} ms",
                parameters_.program, describe_end(status_), refusal_.empty() ? "" : " (" + refusal_ + ")",
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
  sender_.send_kept();
  sender_.socket().finish();
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
  close_connection();
}

CountsMessage TelemetryProcess::counts() const noexcept {
  CountsMessage sum = counts_;
  sum.written += earlier_.written;
  sum.refused += earlier_.refused;
  sum.failed += earlier_.failed;
  sum.incompatible_readers += earlier_.incompatible_readers;
  return sum;
}

}  // namespace sextant::ecu
