#pragma once

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <future>
#include <memory>
#include <string>
#include <thread>

#include "common/fault_injection.hpp"
#include "sextant/config/plant_config.hpp"
#include "sextant/hil/lockstep_plant.hpp"
#include "sextant/hil/plant_server.hpp"
#include "sextant/hil/shared_memory_link.hpp"
#include "sextant/hil/shared_memory_plant_end.hpp"
#include "sextant/hil/udp_plant_end.hpp"
#include "sextant/power_stage/live_power_stage.hpp"
#include "sextant/realtime/latency_histogram.hpp"
#include "sextant/realtime/periodic_task.hpp"
#include "sextant/realtime/processor_latency.hpp"
#include "sextant/realtime/thread_setup.hpp"
#include "sextant/run/mil_runner.hpp"
#include "sextant/run/observed_power_stage.hpp"
#include "sextant/run/scenario.hpp"

namespace sextant::plant {

/// The plant as a process: the simulated power stage, the link, and the thread that runs both in real time.
class Plant {
 public:
  /// Opens stage and link. Throws std::runtime_error with one sentence where one cannot be opened.
  /// fault_socket: on which it takes faults; empty for none. scenario: that the drive of a lockstep plays,
  /// with load and evaluation of it; null for none, not owned.
  explicit Plant(const PlantConfig& config, const std::string& fault_socket = {},
                 const Scenario* scenario = nullptr);
  ~Plant();

  /// Starts the plant's thread. Throws when real-time rights are required and refused.
  void start();

  /// Ends the thread; safe to call twice.
  void stop();

  /// True once the drive of a lockstep has ended, timed out, or played another scenario.
  [[nodiscard]] bool ended() const noexcept { return ended_.load(std::memory_order_acquire); }

  /// Why the run ended early; empty where it did not. Once ended.
  [[nodiscard]] const std::string& problem() const noexcept { return problem_; }

  /// True once a drive has joined the lockstep.
  [[nodiscard]] bool has_joined() const noexcept { return joined_.load(std::memory_order_relaxed); }

  /// Why the result is not that of the scenario: the drive has played none or another one. Empty where it has
  /// played it; once stopped.
  [[nodiscard]] std::string other_play() const;

  /// Of the scenario so far; once stopped.
  [[nodiscard]] MilResult result() const { return observed_->result(); }

  /// Logs the events since the last call: changes of the gates, or a drive that has joined the lockstep.
  void log_events();

  /// Takes the fault that waits at the socket.
  void poll_faults() {
    if (faults_) faults_->poll();
  }

  /// The report of the run, for people; once stopped.
  void print_report(std::FILE* out) const;

 private:
  [[nodiscard]] FaultableDriveIo& stage() noexcept { return observed_ ? observed_->io() : stage_->io(); }
  [[nodiscard]] DriveIo<double>& io() noexcept {
    return faults_ ? faults_->io() : static_cast<DriveIo<double>&>(stage());
  }
  void observe(const DriveReport& report, std::int64_t t_ns, double omega_m);
  void run(std::future<void> rights_checked);
  template <class Server>
  void run_real_time(Server& server);
  void run_lockstep();
  [[nodiscard]] Ring<GateEvent>& events() { return udp_ ? udp_->events() : shared_memory_->events(); }
  [[nodiscard]] const GateGuard& guard() const { return udp_ ? udp_->guard() : shared_memory_->guard(); }
  [[nodiscard]] std::string meeting_point() const;
  void log_join();
  void log(const GateEvent& event);
  void print_real_time(std::FILE* out) const;
  void print_lockstep(std::FILE* out) const;

  PlantConfig config_;
  ProcessorLatency awake_;
  // One of the two.
  std::unique_ptr<LivePowerStage> stage_{};
  std::unique_ptr<ObservedPowerStage> observed_{};
  std::unique_ptr<FaultInjection> faults_{};
  // Those of the configured transport; the others stay empty.
  std::unique_ptr<SharedMemoryLink> link_{};
  std::unique_ptr<LockstepPlant> lockstep_{};
  std::unique_ptr<SharedMemoryPlantEnd> shared_memory_end_{};
  std::unique_ptr<UdpPlantEnd> udp_end_{};
  std::unique_ptr<PlantServer<SharedMemoryPlantEnd>> shared_memory_{};
  std::unique_ptr<PlantServer<UdpPlantEnd>> udp_{};
  PeriodicTask task_;
  LatencyHistogram latency_{};
  LatencyHistogram execution_{};
  std::uint64_t periods_{0};
  std::int64_t longest_to_off_ns_{0};
  std::string problem_{};
  std::uint32_t scenario_{0};  // mark of the one to be played
  bool plays_scenario_{false};
  bool plays_another_{false};
  bool join_logged_{false};
  // Members, because they must outlive the thread: set_value may still run when the value has been read.
  std::promise<RightsReport> rights_{};
  std::promise<void> rights_checked_{};
  std::atomic<bool> stop_{false};
  std::atomic<bool> joined_{false};
  std::atomic<bool> ended_{false};
  std::thread thread_{};
};

}  // namespace sextant::plant
