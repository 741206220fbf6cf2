#include "ecu/virtual_time/virtual_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "ecu/unit/run_report.hpp"
#include "sextant/comms/contract_ranges.hpp"
#include "sextant/files/csv_table.hpp"
#include "sextant/virtual_time/random_bus_events.hpp"

namespace sextant::ecu {
namespace {

constexpr std::int64_t slice_ns = 10'000'000;          // between two checks whether it is over
constexpr std::int64_t hand_shake_ns = 10 * ns_per_s;  // longer no vehicle waits for a drive
constexpr std::int64_t shutdown_ns = ns_per_s;         // beyond the ramp to zero: to the last status frames

template <class... Args>
[[noreturn]] void refuse(fmt::format_string<Args...> text, Args&&... args) {
  throw std::runtime_error{fmt::format(text, std::forward<Args>(args)...)};
}

/// The name that recordings give to the interface of the configuration.
std::string interface_name(const EcuConfig& config) {
  constexpr std::string_view socketcan = "socketcan:";
  const std::string& bus = config.can.bus;
  return bus.starts_with(socketcan) ? bus.substr(socketcan.size()) : "can0";
}

/// A profile as scripts/vcu plays it: straight lines, two rows at one time are a jump.
ProfileParameters profile_of(const std::string& file) {
  const CsvTable table = read_csv(file);
  const std::size_t time = table.column("time_s");
  const std::size_t torque = table.column("torque_nm");
  if (std::find(table.columns.begin(), table.columns.end(), "enable") != table.columns.end())
    refuse("{}:{}: only scripts/vcu plays a column enable", file, table.heading_line);
  table.expect_only({"time_s", "torque_nm"});
  const SignalRange range = contract_ranges().torque_request;
  ProfileParameters profile{.shape = ProfileShape::table, .file = file};
  for (std::size_t k = 0; k < table.rows.size(); ++k) {
    profile.table.push_back({table.rows[k][time], table.rows[k][torque]});
    const std::string problem = validate_point(profile.table, k, profile.shape);
    if (!problem.empty()) refuse("{}: {}", table.place(k), problem);
    if (!range.contains(profile.table.back().value)) {
      refuse("{}: torque_nm is {:g}; the contract's range of torque is {:g} to {:g} N·m", table.place(k),
             profile.table.back().value, range.lowest, range.highest);
    }
  }
  return profile;
}

}  // namespace

void require_waiting_plant(const EcuConfig& config) {
  if (config.waits_for_drive()) return;
  if (config.power_stage_kind() == PowerStageKind::own) {
    refuse(
        "power_stage = \"{}\" runs in real time; --virtual-time needs a power stage that waits for the drive",
        config.power_stage);
  }
  refuse(
      "a plant in another process runs in real time unless hil.pacing is \"lockstep\"; --virtual-time needs "
      "that, or power_stage \"simulated\"");
}

VirtualRun::VirtualRun(const DrivesConfig& config, const VirtualRunOptions& options,
                       const std::vector<DriveIo<double>*>& stages, std::function<std::string()> problem,
                       std::optional<VirtualScenario> scenario)
    : config_{config},
      options_{options},
      problem_{std::move(problem)},
      scenario_{std::move(scenario)},
      ecu_{parts(stages), clock_, bus_, config.on_fault} {
  set_up_sources();
  set_up_files();
  if (options_.bus_seed) disturb_bus();
}

std::vector<VirtualUnit::Parts> VirtualRun::parts(const std::vector<DriveIo<double>*>& stages) {
  std::vector<VirtualUnit::Parts> made;
  for (std::size_t k = 0; k < stages.size(); ++k) {
    const EcuConfig& config = config_.drives.at(k);
    RunDrive& drive =
        drives_.emplace_back(config, *stages[k], bus_, config_.file_of(options_.record_cycles, k));
    VirtualUnit::Parts parts{.unit = drive.unit(), .recorder = drive.recorder()};
    if (scenario_)
      parts.observer = [this, k](const Telemetry<double>& telemetry) { scenario_->observer(k, telemetry); };
    made.push_back(std::move(parts));
  }
  return made;
}

void VirtualRun::set_up_log() {
  std::vector<IdentifierOffset> offsets;
  offsets.reserve(config_.drives.size());
  for (const EcuConfig& drive : config_.drives) offsets.push_back(drive.can.identifier_offset);
  replay_.emplace(select_interface(read_candump(options_.log), options_.log_interface, options_.log), bus_,
                  offsets);
  timeline_.add(replay_->party());
}

void VirtualRun::set_up_sources() {
  std::vector<std::string> sources;
  if (!options_.log.empty()) sources.push_back("the recording " + options_.log);
  if (!options_.profile.empty()) sources.emplace_back("--profile");
  if (options_.lockstep) sources.emplace_back("--lockstep");
  if (sources.size() > 1) {
    refuse("commands come from one source, and there are {}: leave all but one out",
           fmt::join(sources, " and "));
  }
  if (sources.empty() && !scenario_ && !options_.duration_s) {
    refuse("the run has no input and no end: name a recording, a --profile, a --scenario or a --duration");
  }
  timeline_.add(bus_.party());
  if (!options_.log.empty()) set_up_log();
  if (options_.lockstep) {
    client_.emplace(std::cin, stdout, bus_, interface_name(config_.drives.front()));
    timeline_.add(client_->party());
  }
  if (!options_.profile.empty()) read_profile();
  for (std::size_t k = 0; k < drives_.size(); ++k) {
    if (!options_.profile.empty()) play_profile(drives_[k]);
    if (scenario_) play(*scenario_, k);
    if (auto& vehicle = drives_[k].vehicle()) timeline_.add(vehicle->party());
  }
  if (!options_.set_at.empty()) set_parameters();
  ecu_.join(timeline_);
}

void VirtualRun::set_parameters() {
  const std::vector<TimedOverride> at = timed_overrides(options_.set_at);
  for (const TimedOverride& change : at) {
    const bool is_there = std::ranges::any_of(config_.drives, [&change](const EcuConfig& drive) {
      return change.given.counts_for(drive.drive_id);
    });
    if (!is_there) refuse("--set-at: no drive has drive_id {}", change.given.drive_id.value_or(0));
  }
  for (std::size_t k = 0; k < drives_.size(); ++k) {
    ParameterChanges& changes = changes_.emplace_back(config_.drives[k], load_of(options_.load, k, config_),
                                                      drives_[k].unit().shared());
    timeline_.add(timed_changes_.emplace_back(at, changes, clock_, prefix(k)).party());
  }
}

std::string VirtualRun::prefix(std::size_t k) const {
  return drives_.size() == 1 ? std::string{} : fmt::format("drive {}: ", config_.drives[k].drive_id);
}

void VirtualRun::read_profile() {
  const ProfileParameters parameters = profile_of(options_.profile);
  profile_ = Profile{parameters};
  profile_end_ns_ = std::llround(parameters.table.back().t_s * 1e9);
}

void VirtualRun::play_profile(RunDrive& drive) {
  drive.vehicle().emplace(
      VirtualVehicle::Parameters{.torque_limit = contract_ranges().torque_limit.highest,
                                 .identifier_offset = drive.unit().config().can.identifier_offset},
      clock_, bus_, [this](std::int64_t t_ns) { return profile_.value(t_ns); }, profile_end_ns_);
}

/// The frames lie so that the first enable is sent at the scenario's time zero.
void VirtualRun::play(const VirtualScenario& scenario, std::size_t k) {
  RunDrive& drive = drives_[k];
  profile_end_ns_ = scenario.duration_ns;
  VirtualVehicle::Parameters parameters{.enable_from_ns = scenario.begin_ns,
                                        .torque_limit = contract_ranges().torque_limit.highest,
                                        .identifier_offset = drive.unit().config().can.identifier_offset};
  parameters.first_ns = scenario.begin_ns % parameters.period_ns;
  const auto torque = [this, k, &scenario, range = contract_ranges().torque_request](std::int64_t) {
    const double wanted = scenario.torque(k, clock_.now_ns());
    if (!range.contains(wanted)) {
      refuse("{}: the torque is {:g} N·m at {:g} s; the contract's range is {:g} to {:g} N·m", scenario.name,
             wanted, double(clock_.now_ns() - scenario.begin_ns) * 1e-9, range.lowest, range.highest);
    }
    return wanted;
  };
  drive.vehicle().emplace(parameters, clock_, bus_, torque, never_ns);
}

void VirtualRun::set_up_files() {
  for (std::size_t k = 0; k < drives_.size(); ++k) {
    drives_[k].open(config_.file_of(options_.telemetry_out, k), ecu_.drive(k).next_period_ns());
  }
  set_up_frames();
}

void VirtualRun::set_up_frames() {
  if (options_.frames_out.empty()) return;
  std::error_code none;
  if (std::filesystem::equivalent(options_.frames_out, options_.log, none)) {
    refuse("{} cannot be read and written at once", options_.log);
  }
  frames_.emplace(options_.frames_out);
  const std::int64_t origin_ns = replay_ ? replay_->origin_ns() : 0;
  bus_.watch([this, origin_ns, name = interface_name(config_.drives.front())](const CanFrame& frame) {
    frames_->add({origin_ns + frame.received_ns, name, frame});
  });
}

void VirtualRun::disturb_bus() {
  RandomBusEvents events{.seed = options_.bus_seed.value_or(0)};
  // The hand-shake takes some of the time of a profile; events after the end do no harm.
  const auto wanted_ns = std::int64_t(options_.duration_s.value_or(1.0) * 1e9);
  events.end_ns = source_end_ns() == never_ns ? wanted_ns : source_end_ns() + ns_per_s;
  for (const BusEvent& event : draw(events)) bus_.add(event);
}

std::int64_t VirtualRun::source_end_ns() const noexcept {
  if (replay_) return replay_->end_ns() + slice_ns;
  if (drives_.front().vehicle()) return profile_end_ns_;
  return never_ns;
}

void VirtualRun::run() {
  const auto begin = std::chrono::steady_clock::now();
  run_to_end();
  for (RunDrive& drive : drives_) drive.note_end();
  before_shutdown_ns_ = clock_.now_ns();
  ecu_.shut_down();
  std::int64_t ramp_ns = 0;
  for (const EcuConfig& drive : config_.drives)
    ramp_ns = std::max(ramp_ns, drive.drive.drive.command.zero_ramp_ns);
  const std::int64_t limit_ns = ramp_ns + shutdown_ns;
  const std::int64_t deadline_ns = clock_.now_ns() + limit_ns;
  while (!ecu_.stopped() && timeline_.step(deadline_ns)) record_cycles();
  wall_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  // The recorded part is kept even where the run failed.
  if (frames_) frames_->close();
  for (RunDrive& drive : drives_) drive.close();
  if (const std::string failure = recording_failure(); !failure.empty()) throw std::runtime_error{failure};
  if (!ecu_.stopped()) {
    refuse("the drive did not shut down within {} s of virtual time", double(limit_ns) * 1e-9);
  }
  for (std::size_t k = 0; k < timed_changes_.size(); ++k) {
    if (!drives_[k].end().latched.any()) timed_changes_[k].require_all();
  }
}

void VirtualRun::run_to_end() {
  const std::int64_t scenario_end_ns = scenario_ ? scenario_->begin_ns + scenario_->duration_ns : never_ns;
  const std::int64_t wanted_ns =
      options_.duration_s ? std::int64_t(std::llround(*options_.duration_s * 1e9)) : scenario_end_ns;
  const std::int64_t end_ns = replay_ ? std::min(wanted_ns, source_end_ns()) : wanted_ns;
  while (clock_.now_ns() < end_ns) {
    timeline_.run_until(std::min(end_ns, clock_.now_ns() + slice_ns));
    record_cycles();
    if (!recording_failure().empty()) return;
    if (ecu_.has_ended() || (problem_ && !problem_().empty())) return;
    if (client_ && client_->is_over()) return;
    if (!drives_.front().vehicle() || scenario_) continue;  // a scenario has its length
    if (vehicles_are_done()) return;
  }
}

/// A drive that does not get ready for its vehicle is not waited for.
bool VirtualRun::vehicles_are_done() const {
  const bool is_too_late = clock_.now_ns() > hand_shake_ns;
  return std::ranges::all_of(drives_, [is_too_late](const RunDrive& drive) {
    const VirtualVehicle& vehicle = *drive.vehicle();
    return vehicle.phase() == VirtualVehicle::Phase::done || (is_too_late && !vehicle.enabled_ns());
  });
}

void VirtualRun::record_cycles() {
  for (RunDrive& drive : drives_) drive.record_cycles();
}

std::string VirtualRun::recording_failure() const {
  for (const RunDrive& drive : drives_) {
    if (std::string failure = drive.failure(); !failure.empty()) return failure;
  }
  return {};
}

const RunDrive& VirtualRun::worst() const {
  const auto found =
      std::ranges::find_if(drives_, [](const RunDrive& drive) { return drive.verdict() != Verdict::pass; });
  return found == drives_.end() ? drives_.front() : *found;
}

Verdict VirtualRun::verdict() const {
  return worst().verdict();
}

std::string VirtualRun::reason() const {
  const RunDrive& drive = worst();
  const std::string name =
      drives_.size() == 1 ? std::string{} : fmt::format("drive {}: ", drive.unit().config().drive_id);
  switch (drive.verdict()) {
    case Verdict::tripped:
      return name + tripped_text(drive.end().first_fault, source());
    case Verdict::no_torque:
      return name + fmt::format("the drive was not ready within {} s", double(before_shutdown_ns_) * 1e-9);
    default:
      return "";
  }
}

std::string VirtualRun::source() const {
  if (scenario_) return scenario_->name;
  if (client_) return "--lockstep";
  return options_.profile.empty() ? options_.log : options_.profile;
}

void VirtualRun::print_report(std::FILE* out) const {
  const double virtual_s = double(clock_.now_ns()) * 1e-9;
  fmt::print(out, "virtual time {:.3f} s in {:.3f} s: {:.0f} times real time\n", virtual_s, wall_s_,
             virtual_s / std::max(wall_s_, 1e-9));
  const auto print_name = [&](const RunDrive& drive) {
    if (drives_.size() > 1) fmt::print(out, "drive {}\n", drive.unit().config().drive_id);
  };
  for (std::size_t k = 0; k < drives_.size(); ++k) {
    print_name(drives_[k]);
    drives_[k].print_periods_and_commands(out, ecu_.drive(k).wakes());
  }
  print_can(out);
  for (const TimedChanges& changes : timed_changes_) {
    for (const std::string& line : changes.report()) fmt::print(out, "{}\n", line);
  }
  for (const RunDrive& drive : drives_) {
    print_name(drive);
    drive.print_end(out);
  }
}

void VirtualRun::print_can(std::FILE* out) const {
  std::uint64_t clamped = 0;
  for (std::size_t k = 0; k < ecu_.size(); ++k) clamped += ecu_.drive(k).clamped();
  ecu::print_can(out, bus_.stats(), clamped);
  if (replay_ && replay_->left_out() > 0) {
    fmt::print(out, "  {} status frames of the recording were left out\n", replay_->left_out());
  }
  if (options_.bus_seed) {
    const VirtualCanBus::Counts& counts = bus_.counts();
    fmt::print(out, "  disturbed with seed {}: {} lost, {} corrupted, {} late, {} doubled of {}\n",
               *options_.bus_seed, counts.lost, counts.corrupted, counts.delayed, counts.doubled, counts.put);
  }
}

}  // namespace sextant::ecu
