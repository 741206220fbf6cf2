#include "sextant/run/observed_power_stage.hpp"

#include <chrono>
#include <memory>
#include <type_traits>

#include "observed_run.hpp"

namespace sextant {
namespace {

SimulatedPowerStageParameters on_time(const SimulatedPowerStageParameters& parameters) {
  SimulatedPowerStageParameters placed = parameters;
  placed.io.load_origin_ns = ObservedPowerStage::begin_ns(parameters.io.period_ns);
  return placed;
}

MechanicalLoad::Parameters from_zero(const MechanicalLoad::Parameters& load) {
  MechanicalLoad::Parameters placed = load;
  placed.torque_begins_at_zero = true;
  return placed;
}

}  // namespace

/// What does not depend on the type of the plant.
class ObservedPowerStage::Impl {
 public:
  using Clock = std::chrono::steady_clock;

  Impl(const Scenario& scenario, std::int64_t period_ns)
      : scenario_{scenario}, period_ns_{period_ns}, begin_ns_{begin_ns(period_ns)} {}
  virtual ~Impl() = default;

  [[nodiscard]] virtual FaultableDriveIo& io() noexcept = 0;
  virtual void start(const Controller<>* controller, TraceRecorder* trace) = 0;
  [[nodiscard]] virtual double torque(std::int64_t t_ns) = 0;
  [[nodiscard]] virtual MilResult result() const = 0;

  void period(Telemetry<double> telemetry) {
    if (has_ended_) return;
    telemetry.t_ns -= begin_ns_;
    has_ended_ = !take(telemetry) || telemetry.t_ns + period_ns_ > scenario_.duration_ns;
  }
  [[nodiscard]] bool has_ended() const noexcept { return has_ended_; }

 protected:
  /// On the scenario's time; false where the plant has failed.
  virtual bool take(const Telemetry<double>& telemetry) = 0;

  Scenario scenario_;
  std::int64_t period_ns_;
  std::int64_t begin_ns_;
  Clock::time_point started_{Clock::now()};

 private:
  bool has_ended_{false};
};

template <class Appended>
class ObservedPowerStage::Stage final : public Impl {
 public:
  Stage(const Scenario& scenario, const Parameters& parameters)
      : Impl{scenario, parameters.io.period_ns}, stage_{on_time(parameters), from_zero(scenario.load)} {}

  [[nodiscard]] FaultableDriveIo& io() noexcept override { return stage_.io(); }

  void start(const Controller<>* controller, TraceRecorder* trace) override {
    run_ = std::make_unique<Run>(scenario_, period_ns_, stage_.io(), controller, trace);
    started_ = Clock::now();
  }

  [[nodiscard]] double torque(std::int64_t t_ns) override {
    return run_->commands().latest(t_ns - begin_ns_).command.torque;
  }

  [[nodiscard]] MilResult result() const override {
    MilResult result = run_->result(std::chrono::duration<double>(Clock::now() - started_).count());
    result.stopped = result.plant_healthy && !has_ended();
    return result;
  }

 protected:
  bool take(const Telemetry<double>& telemetry) override { return run_->period(telemetry); }

 private:
  using Run = ObservedRun<typename MeteredPowerStageOf<Appended>::Io>;

  MeteredPowerStageOf<Appended> stage_;
  std::unique_ptr<Run> run_{};  ///< from `start` on
};

ObservedPowerStage::ObservedPowerStage(const Scenario& scenario, const Parameters& parameters)
    : impl_{with_appended(parameters,
                          [&]<class Appended>(std::type_identity<Appended>) -> std::unique_ptr<Impl> {
                            return std::make_unique<Stage<Appended>>(scenario, parameters);
                          })} {}

ObservedPowerStage::~ObservedPowerStage() = default;

FaultableDriveIo& ObservedPowerStage::io() noexcept {
  return impl_->io();
}
void ObservedPowerStage::start(const Controller<>* controller, TraceRecorder* trace) {
  impl_->start(controller, trace);
}
double ObservedPowerStage::torque(std::int64_t t_ns) {
  return impl_->torque(t_ns);
}
void ObservedPowerStage::period(const Telemetry<double>& telemetry) {
  impl_->period(telemetry);
}
bool ObservedPowerStage::has_ended() const noexcept {
  return impl_->has_ended();
}
MilResult ObservedPowerStage::result() const {
  return impl_->result();
}

}  // namespace sextant
