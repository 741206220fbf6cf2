#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "bench/keep.hpp"
#include "bench/recorded_run.hpp"

namespace sextant::bench {

inline constexpr std::int64_t period_ns = 25'000;

/// A whole drive that produces torque and replays a recorded run, with a new command at the beginning of
/// each replay: one in 192 periods, which is a frame each 4.8 ms. A period costs no more than the contestant:
/// the time is written into the record itself, and one request is used over and over.
/// Contestant: `void step(std::int64_t, const Measurement<double>&, const DriveRequest<double>&)` and `void
/// reset_estimate()`.
template <class Contestant>
class DriveReplay {
 public:
  explicit DriveReplay(const RecordedRun& run) : measurements_{run.measurements} {
    request_.command.torque_limit = std::numeric_limits<double>::max();
    request_.command.e2e = E2eState::valid;
    for (int k = 0; k < ScenarioCommands::hand_shake_periods; ++k) {
      command(0.0, k + 1 == ScenarioCommands::hand_shake_periods);
      step(measurements_[std::size_t(k)]);
    }
  }

  /// One replay. The loop has nothing in it but the contestant and the time, as that of a bare controller.
  void operator()() {
    begin();
    std::int64_t t_ns = t_ns_;
    for (const Measurement<double>& m : measurements_) {
      contestant_.step(t_ns, m, request_);
      t_ns += period_ns;
    }
    t_ns_ = t_ns;
  }

  /// One period; replays follow one another.
  void next() {
    if (k_ == 0) begin();
    step(measurements_[k_]);
    if (++k_ == measurements_.size()) k_ = 0;
  }

  [[nodiscard]] const Contestant& contestant() const { return contestant_; }

 private:
  void begin() {
    contestant_.reset_estimate();  // the flux estimate is an integral: a replay must not drift
    command(torque_reference, true);
  }

  void command(double torque, bool enable) {
    request_.command.torque = torque;
    request_.command.enable = enable;
    request_.command.received_ns = t_ns_;
    ++request_.command.sequence;
  }

  void step(const Measurement<double>& m) {
    contestant_.step(t_ns_, m, request_);
    t_ns_ += period_ns;
  }

  std::vector<Measurement<double>> measurements_;
  Contestant contestant_{};
  DriveRequest<double> request_{};
  std::int64_t t_ns_{0};
  std::size_t k_{0};
};

/// The drive under test.
struct OurDrive {
  [[gnu::always_inline]] void step(std::int64_t t_ns, const Measurement<double>& m,
                                   const DriveRequest<double>& request) {
    const DriveOutput<double> output = drive.step(t_ns, m, request);
    keep(output);
  }
  void reset_estimate() { controller.reset(); }

  DirectTorqueController<double> controller{{}};
  /// The record begins anew after its end: the jump of the currents there is no fault.
  Drive<double> drive{{.magnetise_first = false,
                       .protection = {.current_jump = 1e6, .speed_error = 1e6},
                       .torque_monitor = {.enabled = false}},
                      controller};
};

}  // namespace sextant::bench
