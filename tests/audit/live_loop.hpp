#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

#include "ecu/threads/control_thread.hpp"
#include "sextant/control/direct_torque_controller.hpp"
#include "sextant/plant/fixed_step_integrator.hpp"
#include "sextant/power_stage/simulated_drive_io.hpp"

namespace sextant::audit {

/// The live control thread on a simulated power stage of fixed step, with all that crosses to and from it:
/// the calling thread plays the receive, transmit and telemetry threads. Torque of both signs, disabled at
/// times, so that diode events are among what runs.
class LiveLoop {
 public:
  /// `Around` is a DriveIo that is made of another one and sits between the thread and the power stage.
  template <class Around>
  LiveLoop(const RealtimeParameters& realtime, std::int32_t period_ns, Around&& around)
      : shared_{period_ns, realtime.wake_every_periods},
        io_{{.period_ns = period_ns}, plant_, integrator_, load_},
        controller_{{{.period_ns = period_ns}}},
        drive_{{.period_ns = period_ns}, controller_},
        task_{{.period_ns = period_ns, .wake_every_periods = realtime.wake_every_periods}, drive_, shared_},
        control_{realtime, around(io_), task_, shared_} {}

  [[nodiscard]] RightsReport start() {
    RightsReport rights = control_.start();
    control_.go();
    return rights;
  }

  /// Feeds and drains until `done` holds.
  template <class Condition>
  void run_until(Condition&& done) {
    while (!done()) {
      command();
      drain();
      std::this_thread::sleep_for(std::chrono::milliseconds{2});
    }
  }

  void stop() {
    shared_.shutdown.store(true, std::memory_order_release);
    run_until([this] { return shared_.stopped.load(std::memory_order_acquire); });
    control_.join();
    drain();
  }

  [[nodiscard]] const ecu::WakeRecord& last_wake() const noexcept { return last_wake_; }
  /// It has made most of the commanded torque once.
  [[nodiscard]] bool has_worked() const noexcept { return peak_torque_ > 10.0; }

 private:
  void command() {
    ++sequence_;
    // A reset, then a disable, then work: a fault by a machine that stopped is over within 40 ms.
    const std::uint64_t phase = sequence_ % 20;
    shared_.command.store({.torque = sequence_ % 8 < 4 ? 15.0 : -15.0,
                           .torque_limit = 100.0,
                           .enable = phase > 1,
                           .fault_reset = phase == 0,
                           .received_ns = now_ns(),
                           .sequence = sequence_,
                           .e2e = E2eState::valid});
  }

  void drain() {
    Telemetry<double> telemetry;
    while (shared_.telemetry.pop(telemetry)) peak_torque_ = std::max(peak_torque_, telemetry.torque);
    ecu::StageRecord stages;
    while (shared_.stages.pop(stages)) {
    }
    while (shared_.wakes.pop(last_wake_)) {
    }
    (void)shared_.status.latest();
  }

  ecu::SharedState shared_;
  MechanicalLoad load_{{.imposed_speed = ProfileParameters{.value = 30.0}}};
  DrivePlant<double> plant_{{}};
  FixedStepIntegrator<DrivePlant<double>> integrator_{};
  SimulatedDriveIo<DrivePlant<double>> io_;
  DirectTorqueController<double> controller_;
  Drive<double> drive_;
  ecu::ControlTask task_;
  ecu::ControlThread control_;
  ecu::WakeRecord last_wake_{};
  double peak_torque_{0.0};
  std::uint64_t sequence_{0};
};

}  // namespace sextant::audit
