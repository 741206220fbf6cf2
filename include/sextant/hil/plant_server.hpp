#pragma once

#include <cstdint>

#include "sextant/core/drive_io.hpp"
#include "sextant/core/nonblocking.hpp"
#include "sextant/hil/gate_guard.hpp"
#include "sextant/hil/link_records.hpp"
#include "sextant/realtime/ring.hpp"

namespace sextant {

/// A change of the cause of the gates' state.
struct GateEvent {
  std::int64_t t_ns{};             ///< beginning of the period in which it changed [ns]
  GateCause cause{};               ///< new cause
  std::int64_t last_pattern_ns{};  ///< time of the last pattern [ns]
  std::int64_t off_since_ns{};     ///< time from which no leg is driven [ns]
};

/// Runs a power stage in real time for a drive in another process, once a plant period:
/// measure, publish, receive the newest pattern, apply it or turn the gates off.
/// End: `take`, `gates_enabled`, `drive_present`, `publish` and `same_clock` as in SharedMemoryPlantEnd.
template <class End>
class PlantServer {
 public:
  /// Stage and end are not owned and must outlive this object.
  PlantServer(const GateGuard::Parameters& parameters, DriveIo<double>& stage, End& end)
      : stage_{stage}, end_{end}, guard_{on_this_link(parameters)} {}

  /// The plant period that begins at t_ns [ns].
  void step(std::int64_t t_ns) noexcept SEXTANT_NONBLOCKING {
    const Measurement<double> measured = stage_.read(t_ns);
    MeasurementRecord record = to_record(t_ns, measured);
    record.pattern_number = guard_.pattern_number();
    end_.publish(record);
    if (!measured.plausible) ++implausible_;

    DrivePatternRecord command;
    const bool fresh = end_.take(command);
    stage_.write(guard_.step(t_ns, fresh ? &command : nullptr, end_.gates_enabled(), end_.drive_present()));
    if (guard_.is_reportable()) {
      events_.push({t_ns, guard_.cause(), guard_.last_pattern_ns(), guard_.off_since_ns()});
    }
  }

  /// For one other thread.
  [[nodiscard]] Ring<GateEvent>& events() noexcept { return events_; }

  /// For the thread that steps, or once it has ended.
  [[nodiscard]] const GateGuard& guard() const noexcept { return guard_; }
  [[nodiscard]] std::uint64_t implausible() const noexcept { return implausible_; }

 private:
  static GateGuard::Parameters on_this_link(GateGuard::Parameters parameters) noexcept {
    parameters.same_clock = End::same_clock;
    return parameters;
  }

  DriveIo<double>& stage_;
  End& end_;
  GateGuard guard_;
  Ring<GateEvent> events_{1024};
  std::uint64_t implausible_{0};
};

}  // namespace sextant
