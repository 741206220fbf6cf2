#include "telemetry_conversion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

namespace sextant {
namespace {

static_assert(int{sextant_INIT} == int(DriveState::init));
static_assert(int{sextant_STANDBY} == int(DriveState::standby));
static_assert(int{sextant_READY} == int(DriveState::ready));
static_assert(int{sextant_MAGNETISING} == int(DriveState::magnetising));
static_assert(int{sextant_TORQUE} == int(DriveState::torque));
static_assert(int{sextant_DERATED} == int(DriveState::derated));
static_assert(int{sextant_FAULT} == int(DriveState::fault));
static_assert(int{sextant_SHUTDOWN} == int(DriveState::shutdown));

static_assert(int{sextant_SLEEP} == int(WaitMode::sleep));
static_assert(int{sextant_SPIN} == int(WaitMode::spin));
static_assert(int{sextant_HYBRID} == int(WaitMode::hybrid));
static_assert(int{sextant_OTHER} == int(SchedulingPolicy::other));
static_assert(int{sextant_FIFO} == int(SchedulingPolicy::fifo));
static_assert(int{sextant_DEADLINE} == int(SchedulingPolicy::deadline));

sextant_DriveStateKind kind_of(DriveState state) noexcept {
  return static_cast<sextant_DriveStateKind>(state);
}

bool all_finite(std::initializer_list<double> values) noexcept {
  return std::ranges::all_of(values, [](double x) { return std::isfinite(x); });
}

/// Copies as much as fits, never cutting a UTF-8 character, and terminates.
template <std::size_t size>
void copy_text(std::string_view text, char (&out)[size]) noexcept {
  std::size_t n = std::min(text.size(), size - 1);
  const auto continues = [&](std::size_t i) {
    return (static_cast<unsigned char>(text[i]) & 0xC0U) == 0x80U;
  };
  while (n > 0 && n < text.size() && continues(n)) --n;
  std::fill(std::copy_n(text.begin(), n, out), out + size, '\0');
}

struct StageMembers {
  Stage stage;
  double sextant_RealTimeStatistics::* p50_us;
  double sextant_RealTimeStatistics::* p99_9_us;
  double sextant_RealTimeStatistics::* max_us;
};

constexpr std::array stage_members{
    StageMembers{Stage::read, &sextant_RealTimeStatistics::read_p50_us,
                 &sextant_RealTimeStatistics::read_p99_9_us, &sextant_RealTimeStatistics::read_max_us},
    StageMembers{Stage::commands, &sextant_RealTimeStatistics::commands_p50_us,
                 &sextant_RealTimeStatistics::commands_p99_9_us,
                 &sextant_RealTimeStatistics::commands_max_us},
    StageMembers{Stage::drive, &sextant_RealTimeStatistics::drive_p50_us,
                 &sextant_RealTimeStatistics::drive_p99_9_us, &sextant_RealTimeStatistics::drive_max_us},
    StageMembers{Stage::write, &sextant_RealTimeStatistics::write_p50_us,
                 &sextant_RealTimeStatistics::write_p99_9_us, &sextant_RealTimeStatistics::write_max_us},
    StageMembers{Stage::push, &sextant_RealTimeStatistics::push_p50_us,
                 &sextant_RealTimeStatistics::push_p99_9_us, &sextant_RealTimeStatistics::push_max_us}};
static_assert(stage_members.size() == stage_count);

bool convert_stages(const RealTimeSample& in, sextant_RealTimeStatistics& out) noexcept {
  bool finite = true;
  for (const StageMembers& members : stage_members) {
    const StageFigures& figures = in.stages[static_cast<std::size_t>(members.stage)];
    out.*members.p50_us = figures.p50_us;
    out.*members.p99_9_us = figures.p99_9_us;
    out.*members.max_us = figures.max_us;
    finite = finite && all_finite({figures.p50_us, figures.p99_9_us, figures.max_us});
  }
  return finite;
}

void convert_overruns(const RealTimeSample& in, sextant_RealTimeStatistics& out) noexcept {
  const auto overruns = [&in](OverrunCause cause) {
    return in.overruns_by_cause[static_cast<std::size_t>(cause)];
  };
  out.overruns_machine = overruns(OverrunCause::machine_gap);
  out.overruns_stage_gap = overruns(OverrunCause::stage_gap);
  out.overruns_late_wake = overruns(OverrunCause::late_wake);
  out.overruns_own_execution = overruns(OverrunCause::long_execution);
  out.overruns_without_gap = in.overruns_without_gap;
  out.gaps = in.gaps;
  out.longest_gap_us = in.longest_gap_us;
}

void convert_scheduling(const RealTimeSample& in, sextant_RealTimeStatistics& out) noexcept {
  out.wait = static_cast<sextant_WaitKind>(in.wait);
  out.policy = static_cast<sextant_SchedulingKind>(in.policy);
  out.page_faults = in.page_faults;
  out.voluntary_switches = in.voluntary_switches;
  out.involuntary_switches = in.involuntary_switches;
  out.run_delay_us = in.run_delay_us;
  out.steal_us = in.steal_us;
  out.real_time_scheduling = in.real_time_scheduling;
  out.memory_locked = in.memory_locked;
}

}  // namespace

bool convert(const TelemetryIntervalRecord<double>& in, std::uint64_t dropped,
             sextant_DriveTelemetry& out) noexcept {
  bool finite = true;
  const auto narrow = [&finite](double x) {
    const float y = static_cast<float>(x);
    finite = finite && std::isfinite(y);
    return y;
  };
  out.t_ns = in.t_ns;
  out.periods = in.periods;
  out.dropped = dropped;
  out.torque_requested_nm = narrow(in.torque_requested_nm);
  out.torque_reference_nm = narrow(in.torque_reference_nm);
  out.torque_mean_nm = narrow(in.torque_mean_nm);
  out.torque_min_nm = narrow(in.torque_min_nm);
  out.torque_max_nm = narrow(in.torque_max_nm);
  out.flux_mean_wb = narrow(in.flux_mean_wb);
  out.flux_min_wb = narrow(in.flux_min_wb);
  out.flux_max_wb = narrow(in.flux_max_wb);
  out.current_mean_a = narrow(in.current_mean_a);
  out.current_min_a = narrow(in.current_min_a);
  out.current_max_a = narrow(in.current_max_a);
  out.i_a_a = narrow(in.i_a_a);
  out.i_b_a = narrow(in.i_b_a);
  out.i_c_a = narrow(in.i_c_a);
  out.flux_angle_rad = narrow(in.flux_angle_rad);
  out.speed_rad_s = narrow(in.speed_rad_s);
  out.u_dc_v = narrow(in.u_dc_v);
  out.i_dc_a = narrow(in.i_dc_a);
  out.power_w = narrow(in.power_w);
  out.state = kind_of(in.state);
  out.sector = in.sector;
  out.command_counter = in.command_counter;
  out.command_received_ns = in.command_received_ns;
  return finite;
}

bool convert(const DriveStateSample& in, sextant_DriveState& out) noexcept {
  out.t_ns = in.t_ns;
  out.state = kind_of(in.state);
  out.lockout = in.lockout;
  out.faults_active = in.active.bits();
  out.faults_latched = in.latched.bits();
  out.first_fault = in.first_fault ? int(*in.first_fault) : -1;
  out.fault_total = in.fault_total;
  copy_text(in.reason, out.reason);
  return true;
}

bool convert(const RealTimeSample& in, sextant_RealTimeStatistics& out) noexcept {
  out.t_ns = in.t_ns;
  out.period_ns = in.period_ns;
  out.wake_every_periods = in.wake_every_periods;
  out.periods = in.periods;
  out.periods_missed = in.periods_missed;
  out.overruns = in.overruns;
  out.wake_latency_p50_us = in.wake_latency_p50_us;
  out.wake_latency_p99_us = in.wake_latency_p99_us;
  out.wake_latency_p99_9_us = in.wake_latency_p99_9_us;
  out.wake_latency_p99_99_us = in.wake_latency_p99_99_us;
  out.wake_latency_max_us = in.wake_latency_max_us;
  out.execution_p50_us = in.execution_p50_us;
  out.execution_p99_us = in.execution_p99_us;
  out.execution_p99_9_us = in.execution_p99_9_us;
  out.execution_p99_99_us = in.execution_p99_99_us;
  out.execution_max_us = in.execution_max_us;
  out.telemetry_dropped = in.telemetry_dropped;
  out.commands_received = in.commands_received;
  out.commands_rejected = in.commands_rejected;
  convert_overruns(in, out);
  convert_scheduling(in, out);
  return convert_stages(in, out) &&
         all_finite({in.wake_latency_p50_us, in.wake_latency_p99_us, in.wake_latency_p99_9_us,
                     in.wake_latency_p99_99_us, in.wake_latency_max_us, in.execution_p50_us,
                     in.execution_p99_us, in.execution_p99_9_us, in.execution_p99_99_us, in.execution_max_us,
                     in.longest_gap_us, in.run_delay_us, in.steal_us});
}

}  // namespace sextant
