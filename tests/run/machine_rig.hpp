#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>

#include "run/machine_run.hpp"
#include "sextant/drive/run_cycle.hpp"

namespace sextant {

using Spoil = std::function<void(Measurement<double>&)>;

/// A drive with its plant, whose measurements may be spoilt.
class MachineRig final : public DriveIo<double> {
 public:
  MachineRig(const TestMachine& machine, const MachineRun& r) : MachineRig{machine_config(machine, r)} {}
  explicit MachineRig(const ScenarioConfig& config)
      : config_{config},
        stage_{config_.drive.plant, config_.scenario.load},
        controller_{make_controller(config_.drive)},
        drive_{config_.drive.drive, *controller_} {}

  Measurement<double> read(std::int64_t t_ns) noexcept override {
    Measurement<double> m = stage_.io().read(t_ns);
    if (spoil) spoil(m);
    return m;
  }
  void write(const GatePattern& pattern) noexcept override { stage_.io().write(pattern); }

  DriveRequest<double> latest(std::int64_t t_ns) noexcept {
    DriveRequest<double> request;
    request.command = {.torque = torque,
                       .torque_limit = 1e6,
                       .enable = enable,
                       .fault_reset = fault_reset,
                       .received_ns = t_ns,
                       .sequence = ++sequence_,
                       .e2e = E2eState::valid};
    request.external = external;
    return request;
  }
  void push(const Telemetry<double>& t) noexcept { telemetry = t; }

  void run(double seconds) {
    const std::int64_t end = t_ns_ + std::llround(seconds * 1e9);
    for (; t_ns_ < end; t_ns_ += config_.drive.drive.period_ns) {
      run_cycle(t_ns_, *this, *this, drive_, *this);
      peak_current = std::max(peak_current, magnitude(stage_.io().plant().i_s()));
    }
  }
  /// Until the drive makes torque; false where it does not within that time [s].
  [[nodiscard]] bool start(double within) {
    enable = false;
    run(3e-3);
    enable = true;
    for (double waited = 0.0; waited < within && !makes_torque(drive_.state()); waited += 1e-3) run(1e-3);
    return makes_torque(drive_.state());
  }
  /// Until the fault is gone; readings of the gates' rest are forgotten within 30 ms.
  void reset() {
    enable = false;
    fault_reset = true;
    for (int n = 0; n < 100 && drive_.state() == DriveState::fault; ++n) run(1e-3);
    fault_reset = false;
  }
  [[nodiscard]] double mean_torque(double seconds) {
    double sum = 0.0;
    int n = 0;
    for (double t = 0.0; t < seconds; t += double(config_.drive.drive.period_ns) * 1e-9, ++n) {
      run(double(config_.drive.drive.period_ns) * 1e-9);
      sum += stage_.io().plant().tau_e();
    }
    return sum / n;
  }
  [[nodiscard]] DriveState state() const { return drive_.state(); }
  [[nodiscard]] double time_s() const { return double(t_ns_) * 1e-9; }
  [[nodiscard]] const ProtectionLimits<>& limits() const { return config_.drive.drive.protection; }

  Spoil spoil{};
  double torque{};
  bool enable{};
  bool fault_reset{};
  double peak_current{};
  FaultSet external{};
  Telemetry<double> telemetry{};

 private:
  ScenarioConfig config_;
  MeteredPowerStage stage_;
  std::unique_ptr<Controller<double>> controller_;
  Drive<double> drive_;
  std::int64_t t_ns_{};
  std::uint64_t sequence_{};
};

}  // namespace sextant
