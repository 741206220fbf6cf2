// The control thread of the live drive under four witnesses: heap allocations, locks, page faults and system
// calls, counted over its periods from a warm loop on. Exit status 0 when there are none, but for
// clock_nanosleep where it sleeps. --seed commits one violation, which must be found.

#include <atomic>
#include <cstdio>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include "audit/linked_plant.hpp"
#include "audit/live_loop.hpp"
#include "audit/lock_counter.hpp"
#include "audit/system_call_trap.hpp"
#include "common/command_line.hpp"
#include "common/program.hpp"
#include "sextant/realtime/scheduler_sample.hpp"
#include "sextant/realtime/thread_setup.hpp"
#include "support/allocation_counter.hpp"

namespace sextant::audit {
namespace {

struct Options {
  std::int64_t periods{10'000'000};
  double period_us{5.0};
  std::string wait{"spin"};
  std::string seed{"none"};
  bool shared_memory{false};
};

struct Counts {
  std::uint64_t allocations{};
  std::uint64_t locks{};
};

/// One violation, on demand.
class Seed {
 public:
  explicit Seed(std::string kind) : kind_{std::move(kind)} {
    const auto size = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    page_ =
        static_cast<char*>(mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    // Not resident, whatever has been locked.
    munlock(page_, size);
    madvise(page_, size, MADV_DONTNEED);
  }

  void commit() {
    if (kind_ == "allocation") leak_ = std::make_unique<int>(1);
    if (kind_ == "lock") const std::lock_guard hold{mutex_};
    if (kind_ == "page_fault") *static_cast<volatile char*>(page_) = 1;
    if (kind_ == "system_call") (void)::write(-1, "", 0);
  }

 private:
  std::string kind_;
  char* page_;
  std::unique_ptr<int> leak_{};
  std::mutex mutex_{};
};

/// Sits on the control thread, before its power stage, and counts.
class WitnessIo final : public DriveIo<double> {
 public:
  WitnessIo(DriveIo<double>& io, const Options& options) : io_{io}, options_{options} {}

  [[nodiscard]] Measurement<double> read(std::int64_t t_ns) noexcept override {
    ++period_;
    if (period_ == warm_up) begin();
    if (period_ == warm_up + options_.periods / 2 && seed_) seed_->commit();
    if (period_ == warm_up + options_.periods) end();
    return io_.read(t_ns);
  }
  void write(const GatePattern& pattern) noexcept override { io_.write(pattern); }

  [[nodiscard]] bool done() const { return done_.load(std::memory_order_acquire); }
  [[nodiscard]] const Counts& counts() const { return counts_; }
  /// Of the control thread since the count began; asked of the kernel by another thread. [-]
  [[nodiscard]] std::uint64_t page_faults() const {
    const SchedulerSample now = SchedulerSampler{thread_id_}.sample();
    if (!now.valid) throw std::runtime_error("/proc does not tell the control thread's page faults");
    return now.minor_faults + now.major_faults - faults_before_;
  }

 private:
  static constexpr std::int64_t warm_up = 20'000;

  void begin() {
    // Made here, after the program's memory has been locked.
    if (options_.seed != "none") seed_.emplace(options_.seed);
    thread_id_ = gettid();
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    faults_before_ = static_cast<std::uint64_t>(usage.ru_minflt + usage.ru_majflt);
    trap_system_calls(options_.wait != "spin");
    counts_ = {testing::allocations(), locks()};
  }

  void end() {
    counts_.allocations = testing::allocations() - counts_.allocations;
    counts_.locks = locks() - counts_.locks;
    stop_counting_system_calls();
    done_.store(true, std::memory_order_release);
  }

  DriveIo<double>& io_;
  const Options& options_;
  std::optional<Seed> seed_{};
  std::int64_t period_{0};
  int thread_id_{0};
  std::uint64_t faults_before_{0};
  Counts counts_{};
  std::atomic<bool> done_{false};
};

RealtimeParameters realtime_parameters(const Options& options) {
  RealtimeParameters p;
  p.wake_every_periods = 1;
  p.wait.mode = options.wait == "spin"     ? WaitMode::spin
                : options.wait == "hybrid" ? WaitMode::hybrid
                                           : WaitMode::sleep;
  p.wait.spin_margin_ns = 2'000;
  return p;
}

/// One line of the table; the count that may not be above zero.
bool judge(const char* what, std::uint64_t count, const std::string& remark = {}) {
  fmt::print("  {:<18} {:>6}  {}{}\n", what, count, count == 0 ? "ok" : "FOUND",
             remark.empty() ? "" : " " + remark);
  return count == 0;
}

int run(const Options& options) {
  std::unique_ptr<LinkedPlant> linked;
  std::unique_ptr<WitnessIo> witness;
  const auto period_ns = static_cast<std::int32_t>(options.period_us * 1e3);
  LiveLoop loop{realtime_parameters(options), period_ns, [&](DriveIo<double>& io) -> DriveIo<double>& {
                  if (options.shared_memory) linked = std::make_unique<LinkedPlant>(io, period_ns);
                  witness = std::make_unique<WitnessIo>(linked ? linked->drive_io() : io, options);
                  return *witness;
                }};
  const RightsReport rights = loop.start();
  for (const std::string& refusal : rights.refusals) fmt::print("  {}\n", refusal);
  // A machine that stands still may keep the drive from working for all of the periods: it then gets more.
  const std::int64_t end_ns = now_ns() + 60 * ns_per_s;
  loop.run_until([&] { return witness->done() && (loop.has_worked() || now_ns() > end_ns); });
  const std::uint64_t faults = witness->page_faults();
  loop.stop();
  if (linked) linked->stop();
  fmt::print("{} control periods of {} us, wait = \"{}\", {} of them missed; seed: {}\n", options.periods,
             options.period_us, options.wait, loop.last_wake().periods_missed, options.seed);
  if (linked) {
    fmt::print("  plant behind shared memory: {} measurements, {} patterns\n", linked->measurements(),
               linked->patterns());
    // Some of each: a plant without a processor of its own misses most of them.
    if (linked->measurements() < 50 || linked->patterns() < 50) {
      throw std::runtime_error("the link has not worked");
    }
  }
  if (!loop.has_worked()) throw std::runtime_error("the drive has not worked");
  bool clean = judge("heap allocations", witness->counts().allocations);
  clean &= judge("locks", witness->counts().locks);
  clean &= judge("page faults", faults, rights.memory_locked ? "" : "(memory is not locked)");
  clean &= judge("system calls", trapped_system_calls(),
                 fmt::format("{}{}", fmt::join(trapped_names(), ", "),
                             options.wait == "spin" ? "" : "(clock_nanosleep is allowed)"));
  return clean ? 0 : 1;
}

}  // namespace
}  // namespace sextant::audit

int main(int argc, char** argv) {
  sextant::audit::Options options;
  const sextant::CommandLine line{
      "control_thread_audit",
      "Counts what the control thread of the live drive must not do.",
      "Exit status: 0 if there is nothing, 1 if there is something, 2 if it cannot be run.",
      {{.name = "--periods",
        .value = &options.periods,
        .what = "control periods to watch",
        .least = 1'000,
        .most = 1'000'000'000},
       {.name = "--period-us",
        .value = &options.period_us,
        .what = "control period",
        .least = 1.0,
        .most = 1000.0},
       {.name = "--wait",
        .value = &options.wait,
        .what = "how the thread waits",
        .choices = {"spin", "hybrid", "sleep"}},
       {.name = "--shared-memory",
        .value = &options.shared_memory,
        .what = "the plant on a thread of its own, behind a link"},
       {.name = "--seed",
        .value = &options.seed,
        .what = "commit this violation once",
        .choices = {"none", "allocation", "lock", "page_fault", "system_call"}}}};
  if (const std::optional<int> status = line.parse(argc, argv)) return *status;
  sextant::reserve_little_memory();  // as the programs do
  return sextant::run_program(line.program, [&] { return sextant::audit::run(options); });
}
