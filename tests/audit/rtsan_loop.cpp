// The live control thread for some seconds, to be built with clang's -fsanitize=realtime, which stops the
// program at an allocation, a lock or a blocking system call below a nonblocking function. See
// scripts/check_rtsan. Arguments: seconds, and the violation to commit: none, allocation or lock.

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <string_view>

#include <unistd.h>

#include "audit/live_loop.hpp"

namespace sextant::audit {
namespace {

/// Sits before the power stage and commits one violation.
class SeededIo final : public DriveIo<double> {
 public:
  SeededIo(DriveIo<double>& io, std::string_view seed) : io_{io}, seed_{seed} {}

  [[nodiscard]] Measurement<double> read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING override {
    if (++period_ == 1'000) commit();
    return io_.read(t_ns);
  }
  void write(const GatePattern& pattern) noexcept SEXTANT_NONBLOCKING override { io_.write(pattern); }

 private:
  SEXTANT_TRUSTED_BEGIN
  void commit() noexcept {
    if (seed_ == "allocation") leak_ = std::make_unique<int>(1);
    if (seed_ == "lock") const std::lock_guard hold{mutex_};
    if (seed_ == "system_call") (void)::write(-1, "", 0);
  }
  SEXTANT_TRUSTED_END

  DriveIo<double>& io_;
  std::string_view seed_;
  std::int64_t period_{0};
  std::unique_ptr<int> leak_{};
  std::mutex mutex_{};
};

int run(double seconds, std::string_view seed) {
  RealtimeParameters realtime;
  realtime.lock_memory = false;  // the sanitizer's shadow is larger than a machine
  realtime.policy = SchedulingPolicy::other;
  std::unique_ptr<SeededIo> io;
  LiveLoop loop{realtime, 25'000, [&](DriveIo<double>& stage) -> DriveIo<double>& {
                  io = std::make_unique<SeededIo>(stage, seed);
                  return *io;
                }};
  (void)loop.start();
  const std::int64_t end_ns = now_ns() + std::int64_t(seconds * 1e9);
  const std::int64_t longest_ns = end_ns + 60 * ns_per_s;
  loop.run_until([&] { return now_ns() > (loop.has_worked() ? end_ns : longest_ns); });
  loop.stop();
  if (!loop.has_worked()) {
    std::fputs("rtsan_loop: the drive has not worked\n", stderr);
    return 2;
  }
  std::printf("%llu control periods\n", static_cast<unsigned long long>(loop.last_wake().periods));
  return 0;
}

}  // namespace
}  // namespace sextant::audit

int main(int argc, char** argv) {
  return sextant::audit::run(argc > 1 ? std::atof(argv[1]) : 5.0, argc > 2 ? argv[2] : "none");
}
