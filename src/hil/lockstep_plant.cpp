#include "sextant/hil/lockstep_plant.hpp"

#include "lockstep_poll.hpp"
#include "sextant/hil/link_records.hpp"

namespace sextant {
LockstepPlant::LockstepPlant(SharedMemoryLink& link, DriveIo<double>& stage, std::int64_t timeout_ns) noexcept
    : link_{link},
      memory_{link.memory()},
      stage_{stage},
      timeout_ns_{timeout_ns},
      own_bell_{memory_.plant.doorbell, memory_.drive.asleep},
      drive_bell_{memory_.drive.doorbell, memory_.plant.asleep} {}

LockstepPlant::Outcome LockstepPlant::step() noexcept {
  const std::uint32_t seen = drive_bell_.value();
  DrivePatternRecord command;
  if (!take(command)) {
    if (!drive_bell_.wait(seen, lockstep_poll_ns)) return check_for_drive();
    if (!take(command)) return Outcome::waiting;
  }
  waited_ns_ = 0;
  answer(command);
  return Outcome::stepped;
}

/// The newest request, also one from before this plant's start; one of an earlier drive does not count.
bool LockstepPlant::take(DrivePatternRecord& command) noexcept {
  DrivePatternRecord found;
  if (memory_.command.load(found) == 0) return false;
  if (found.generation != memory_.drive.generation.load(std::memory_order_acquire)) return false;
  if (found.sequence == command_.sequence && found.generation == command_.generation) return false;
  command_ = found;
  command = found;
  return true;
}

LockstepPlant::Outcome LockstepPlant::check_for_drive() noexcept {
  if (sequence_ == 0) return Outcome::waiting;
  if (memory_.drive.present.load(std::memory_order_acquire) == 0) return Outcome::left;
  waited_ns_ += lockstep_poll_ns;
  if (waited_ns_ >= timeout_ns_ || !link_.other_is_attached()) return Outcome::lost;
  return Outcome::waiting;
}

void LockstepPlant::observe_period(const DrivePatternRecord& command) {
  DriveReport report;
  if (sequence_ == 0 || memory_.report.load(report) != command.sequence) return;
  observer_(report, end_ns_, omega_m_);
}

void LockstepPlant::answer(const DrivePatternRecord& command) noexcept {
  if (observer_) observe_period(command);
  GatePattern pattern;
  if (command.has_pattern != 0 && to_pattern(command.pattern, pattern)) stage_.write(pattern);
  if (sequence_ == 0) begin_ns_ = command.t_ns;
  end_ns_ = command.t_ns;
  const Measurement<double> measured = stage_.read(command.t_ns);
  omega_m_ = measured.omega_m;
  MeasurementRecord record = to_record(command.t_ns, measured);
  record.sequence = ++sequence_;
  record.pattern_number = command.sequence;
  record.generation = link_.generation();
  memory_.measurements.push(record);
  own_bell_.ring();
}

}  // namespace sextant
