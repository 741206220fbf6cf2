#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <benchmark/benchmark.h>
#include <dds/dds.h>

#include "bench/bench_drive.hpp"
#include "bench/cpu_clock.hpp"
#include "sextant/core/telemetry.hpp"
#include "sextant/core/telemetry_interval.hpp"
#include "sextant/dds/dds_telemetry.hpp"
#include "sextant/realtime/ring.hpp"
#include "support/source_directory.hpp"
#include "telemetry.h"

namespace sextant::bench {
namespace {

constexpr std::size_t most_drives = 64;
constexpr int periods_per_sample = 40;  // 1 ms: telemetry at 1 kHz
constexpr std::uint32_t domain = 91;

/// A drive, its plant and its way to DDS: the control side pushes each period, the telemetry side drains the
/// ring, makes an interval of 1 ms and publishes it under the drive's own id.
class PublishingDrive {
 public:
  explicit PublishingDrive(std::unique_ptr<DdsTelemetry> dds) : dds_{std::move(dds)} {}

  void run_millisecond() {
    for (int k = 0; k < periods_per_sample; ++k) drive_.run_period(ring_);
    Telemetry<double> telemetry;
    while (ring_.pop(telemetry)) interval_.add(telemetry);
    good_ = dds_->write(interval_.record(), ring_.dropped()) == DdsWrite::ok && good_;
    interval_.reset();
    ++written_;
  }

  [[nodiscard]] DdsTelemetry& dds() noexcept { return *dds_; }
  [[nodiscard]] bool healthy() noexcept { return drive_.healthy() && good_ && ring_.dropped() == 0; }
  [[nodiscard]] std::uint64_t written() const noexcept { return written_; }

 private:
  BenchDrive drive_{};
  Ring<Telemetry<double>> ring_{std::size_t{periods_per_sample}};
  TelemetryInterval<double> interval_{};
  std::unique_ptr<DdsTelemetry> dds_;
  bool good_{true};
  std::uint64_t written_{0};
};

/// A reader of all drives that counts by drive what arrives.
class Monitor {
 public:
  Monitor() : participant_(dds_create_participant(domain, nullptr, nullptr)) {
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
    const dds_entity_t topic = dds_create_topic(participant_, &sextant_DriveTelemetry_desc,
                                                "sextant/DriveTelemetry", nullptr, nullptr);
    reader_ = dds_create_reader(participant_, topic, qos, nullptr);
    dds_delete_qos(qos);
    for (std::size_t n = 0; n < most_drives; ++n) pointers_[n] = &samples_[n];
  }
  Monitor(const Monitor&) = delete;
  Monitor& operator=(const Monitor&) = delete;
  ~Monitor() { dds_delete(participant_); }

  void take() {
    const dds_return_t taken = dds_take(reader_, pointers_, infos_, most_drives, most_drives);
    for (dds_return_t n = 0; n < taken; ++n) {
      if (infos_[n].valid_data) ++seen_[samples_[n].drive_id];
    }
  }
  [[nodiscard]] std::uint64_t seen(std::uint32_t drive_id) { return seen_[drive_id]; }

 private:
  dds_entity_t participant_;
  dds_entity_t reader_{0};
  sextant_DriveTelemetry samples_[most_drives]{};
  void* pointers_[most_drives]{};
  dds_sample_info_t infos_[most_drives]{};
  std::map<std::uint32_t, std::uint64_t> seen_{};
};

/// N drives of one process with everything that hangs on them.
class Fleet {
 public:
  explicit Fleet(std::size_t drives) {
    std::ifstream file(SEXTANT_SOURCE_DIR "/configs/cyclonedds_loopback.xml");
    auto dds = std::make_unique<DdsTelemetry>(
        DdsTelemetry::Parameters{.domain_id = domain,
                                 .drive_id = 1,
                                 .configuration = {std::istreambuf_iterator<char>(file), {}},
                                 .configuration_source = "configs/cyclonedds_loopback.xml"});
    for (std::uint32_t id = 1; id <= drives; ++id) {
      if (id > 1) dds = std::make_unique<DdsTelemetry>(drives_.front()->dds(), id);
      drives_.push_back(std::make_unique<PublishingDrive>(std::move(dds)));
    }
    monitor_ = std::make_unique<Monitor>();
    while (drives_.back()->dds().readers() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  /// The first n drives for so many milliseconds, each with a monitor that looks once a millisecond.
  void run(std::size_t n, std::size_t milliseconds) {
    for (std::size_t ms = 0; ms < milliseconds; ++ms) {
      for (std::size_t k = 0; k < n; ++k) drives_[k]->run_millisecond();
      monitor_->take();
    }
  }

  [[nodiscard]] std::size_t size() const noexcept { return drives_.size(); }
  [[nodiscard]] bool healthy() const {
    return std::ranges::all_of(drives_, [](const auto& drive) { return drive->healthy(); });
  }
  /// Whether the monitor saw each sample of each drive under the drive's own id.
  [[nodiscard]] bool all_seen() {
    for (std::uint32_t id = 1; id <= drives_.size(); ++id) {
      if (monitor_->seen(id) != drives_[id - 1]->written()) return false;
    }
    return true;
  }

 private:
  std::vector<std::unique_ptr<PublishingDrive>> drives_{};
  std::unique_ptr<Monitor> monitor_{};
};

double median(std::vector<double>& values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Counters `us_N`, CPU time of one simulated millisecond of one drive among N, and `ratio_N`, that to a
/// drive alone. The sizes take turns with the same work each, 64 milliseconds of one drive or one of 64.
void growth(benchmark::State& state) {
  constexpr std::size_t sizes[] = {1, 2, 4, 8, 16, 32, 64};
  constexpr int rounds = 40;
  Fleet fleet{most_drives};
  fleet.run(most_drives, 200);
  std::map<std::size_t, std::vector<double>> cost_us;
  std::map<std::size_t, std::vector<double>> ratio;
  for (auto _ : state) {
    for (int round = 0; round < rounds; ++round) {
      for (const std::size_t n : sizes) {
        fleet.run(n, 1);  // into the caches
        const double begin = process_cpu_ns();
        fleet.run(n, most_drives / n);
        cost_us[n].push_back((process_cpu_ns() - begin) * 1e-3 / double(most_drives));
        ratio[n].push_back(cost_us[n].back() / cost_us[1].back());
      }
    }
  }
  for (const std::size_t n : sizes) {
    state.counters["us_" + std::to_string(n)] = median(cost_us[n]);
    state.counters["ratio_" + std::to_string(n)] = median(ratio[n]);
  }
  if (!fleet.healthy()) state.SkipWithError("a drive makes no torque or lost telemetry");
  if (!fleet.all_seen()) state.SkipWithError("a sample did not arrive under the id of its drive");
}
BENCHMARK(growth)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sextant::bench
