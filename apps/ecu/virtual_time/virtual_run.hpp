#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ecu/parameters/load_drives.hpp"
#include "ecu/parameters/parameter_changes.hpp"
#include "ecu/virtual_time/lockstep_client.hpp"
#include "ecu/virtual_time/run_drive.hpp"
#include "ecu/virtual_time/timed_changes.hpp"
#include "ecu/virtual_time/virtual_ecu.hpp"
#include "sextant/config/drives_config.hpp"
#include "sextant/profiles/profile.hpp"
#include "sextant/run/verdict.hpp"
#include "sextant/virtual_time/candump_log.hpp"
#include "sextant/virtual_time/log_replay.hpp"
#include "sextant/virtual_time/virtual_vehicle.hpp"

namespace sextant::ecu {

/// The command line's options of a run in virtual time.
struct VirtualRunOptions {
  std::string log{};                        ///< recording to replay; empty: none
  std::string log_interface{};              ///< of the recording; empty: its only one
  std::string profile{};                    ///< torque profile for a vehicle to play; empty: none
  bool lockstep{false};                     ///< a LockstepClient on the standard streams
  std::string frames_out{};                 ///< recording to write; empty: none
  std::string telemetry_out{};              ///< .csv or .h5; empty: none
  std::string record_cycles{};              ///< recording of the control periods to write; empty: none
  std::optional<double> duration_s{};       ///< virtual time after which the drive is shut down [s]
  std::optional<std::uint64_t> bus_seed{};  ///< of a bus that misbehaves at random [-]
  std::vector<std::string> set_at{};        ///< changes while the drives run, as of timed_overrides()
  LoadDrives load{};                        ///< the configuration with further overrides; for `set_at`
};

/// Throws std::runtime_error with one sentence where the configured plant does not wait for the drive, as
/// virtual time needs.
void require_waiting_plant(const EcuConfig& config);

/// A scenario that a vehicle plays to each drive, and who observes the run. `drive`: by the order of the
/// configuration.
struct VirtualScenario {
  std::string name{};
  std::int64_t begin_ns{};     ///< its time zero on the virtual clock [ns]
  std::int64_t duration_ns{};  ///< [ns]
  /// That the vehicle commands then. [N·m]
  std::function<double(std::size_t drive, std::int64_t t_ns)> torque{};
  /// As of VirtualUnit::Parts.
  std::function<void(std::size_t drive, const Telemetry<double>&)> observer{};
};

/// The configured drives in virtual time, from their first period to their shutdown: commands from a
/// recording, or from a vehicle that plays a profile or a scenario, as fast as the machine allows. Each drive
/// has a vehicle of its own that plays the same. The power stage is whatever is behind the `DriveIo`.
class VirtualRun {
 public:
  /// The power stages, one for each drive, are not owned and must outlive this object. `problem` returns why
  /// the run cannot go on, in one sentence, empty while it can; it is called every 10 ms of virtual time.
  /// Throws std::runtime_error with one sentence where a file cannot be used or the options make no run.
  VirtualRun(const DrivesConfig& config, const VirtualRunOptions& options,
             const std::vector<DriveIo<double>*>& stages, std::function<std::string()> problem = {},
             std::optional<VirtualScenario> scenario = {});
  VirtualRun(const VirtualRun&) = delete;
  VirtualRun& operator=(const VirtualRun&) = delete;

  /// Ends early where there is a problem. Throws std::runtime_error where a file could not be written.
  void run();

  /// The report of the run, for people.
  void print_report(std::FILE* out) const;

  /// How it turned out, the worst of the drives: `no_torque` where one never got ready for the vehicle that
  /// plays a profile, `tripped` where one was in FAULT at the end, else `pass`.
  [[nodiscard]] Verdict verdict() const;
  /// Why it is not `pass`, in one sentence; empty where it is.
  [[nodiscard]] std::string reason() const;

  [[nodiscard]] const Controller<double>& controller(std::size_t drive) const {
    return drives_.at(drive).unit().controller();
  }

 private:
  /// Makes the drives.
  [[nodiscard]] std::vector<VirtualUnit::Parts> parts(const std::vector<DriveIo<double>*>& stages);
  void set_up_sources();
  void set_up_log();
  void read_profile();
  void set_parameters();
  void play_profile(RunDrive& drive);
  void play(const VirtualScenario& scenario, std::size_t k);
  /// Of the sentences about a drive, where there are several: "drive 2: ".
  [[nodiscard]] std::string prefix(std::size_t k) const;
  void set_up_files();
  void set_up_frames();
  void disturb_bus();
  void run_to_end();
  [[nodiscard]] bool vehicles_are_done() const;
  void record_cycles();
  [[nodiscard]] std::string recording_failure() const;
  [[nodiscard]] std::int64_t source_end_ns() const noexcept;
  void print_can(std::FILE* out) const;
  [[nodiscard]] std::string source() const;

  /// The first drive that did not pass; else the first.
  [[nodiscard]] const RunDrive& worst() const;

  DrivesConfig config_;
  VirtualRunOptions options_;
  std::function<std::string()> problem_;
  std::optional<VirtualScenario> scenario_;
  VirtualClock clock_{};
  VirtualCanBus bus_{clock_};
  VirtualTimeline timeline_{clock_};
  std::deque<RunDrive> drives_{};  // each stays where it is
  VirtualEcu ecu_;
  std::deque<ParameterChanges> changes_{};  // one for each drive, where some are wanted
  std::deque<TimedChanges> timed_changes_{};
  Profile profile_{};
  std::int64_t profile_end_ns_{0};
  std::optional<LogReplay> replay_{};
  std::optional<LockstepClient> client_{};
  std::optional<CandumpWriter> frames_{};
  std::int64_t before_shutdown_ns_{0};
  double wall_s_{0.0};
};

}  // namespace sextant::ecu
