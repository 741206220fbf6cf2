#include "sextant/hil/lockstep_drive_io.hpp"

#include <algorithm>

#include "lockstep_poll.hpp"
#include "sextant/hil/link_records.hpp"

namespace sextant {
LockstepDriveIo::LockstepDriveIo(SharedMemoryLink& link, std::int64_t timeout_ns) noexcept
    : link_{link},
      memory_{link.memory()},
      timeout_ns_{timeout_ns},
      own_bell_{memory_.drive.doorbell, memory_.plant.asleep},
      plant_bell_{memory_.plant.doorbell, memory_.drive.asleep},
      sequence_{memory_.command.number()} {}

Measurement<double> LockstepDriveIo::read(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
  Measurement<double> m{.plausible = false};
  if (lost()) return m;
  request(t_ns);
  MeasurementRecord record;
  if (!wait_for_answer(record)) {
    lost_.store(true, std::memory_order_release);
    return m;
  }
  // A restarted plant has lost the state that the drive's estimate follows.
  const bool same = plant_generation_ == 0 || plant_generation_ == record.generation;
  plant_generation_ = record.generation;
  m.i_abc = {record.i_a, record.i_b, record.i_c};
  m.u_dc = record.u_dc;
  m.omega_m = record.omega_m;
  m.plausible = to_pattern(record.applied, m.applied) && record.plausible != 0 && same;
  joined_.store(true, std::memory_order_relaxed);
  was_there_.store(true, std::memory_order_relaxed);
  return m;
}

const char* LockstepDriveIo::loss() const noexcept {
  if (!lost()) return nullptr;
  if (joined()) return "ended or timed out";
  if (was_there()) return "was started, and ended or timed out";
  return "was not started within hil.lockstep_timeout_ms";
}

void LockstepDriveIo::request(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
  ++sequence_;
  if (has_report_) memory_.report.store(report_, sequence_);
  has_report_ = false;
  memory_.command.store({sequence_, t_ns, to_record(pattern_), link_.generation(), has_pattern_ ? 1U : 0U},
                        sequence_);
  has_pattern_ = false;
  own_bell_.ring();
}

bool LockstepDriveIo::answer(MeasurementRecord& record) noexcept SEXTANT_NONBLOCKING {
  const std::uint64_t newest = memory_.measurements.newest();
  return newest != 0 && memory_.measurements.read(newest, record) && record.pattern_number == sequence_ &&
         record.generation == memory_.plant.generation.load(std::memory_order_acquire);
}

SEXTANT_TRUSTED_BEGIN

bool LockstepDriveIo::wait_for_answer(MeasurementRecord& record) noexcept SEXTANT_NONBLOCKING {
  std::int64_t waited_ns = 0;
  for (;;) {
    const std::uint32_t seen = plant_bell_.value();
    if (answer(record)) return true;
    if (plant_bell_.wait(seen, std::min(lockstep_poll_ns, timeout_ns_))) continue;
    waited_ns += lockstep_poll_ns;
    const bool is_there = link_.other_is_attached();
    if (is_there) was_there_.store(true, std::memory_order_relaxed);
    if (waited_ns >= timeout_ns_ || (was_there() && !is_there)) return false;
  }
}

SEXTANT_TRUSTED_END

}  // namespace sextant
