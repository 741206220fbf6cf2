#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sextant/core/telemetry.hpp"
#include "sextant/recording/trace_row.hpp"

namespace sextant {

struct TraceParameters {
  /// One row of the trace; sampled: a whole number of control periods, or a whole part of one. [µs]
  double interval_us{1000};
  int compression{0};  ///< deflate level 0 to 9; 1 writes a quarter of the bytes in twice the time [-]
  /// What is written beside `t_ns`: names of signals and of groups of them (`trace_signals`).
  std::vector<std::string> signals{"standard"};

  [[nodiscard]] const char* validate() const noexcept {
    if (!std::isfinite(interval_us) || interval_us <= 0)
      return "the trace interval must be finite and above zero";
    if (interval_us > 1e9) return "the trace interval must be at most 1000 s";
    if (compression < 0 || compression > 9) return "the trace compression must be between 0 and 9";
    if (signals.empty()) return "the trace needs at least one signal";
    return nullptr;
  }
};

/// The groups that `TraceParameters::signals` may name, `all` first.
[[nodiscard]] std::vector<std::string> trace_groups();

/// Everything that `TraceParameters::signals` may name: the groups first, then each dataset by its path in
/// the file. `channels`: those of a controller, `control/NAME`, which belong to `standard`.
[[nodiscard]] std::vector<std::string> trace_signals(std::span<const ControlChannel> channels = {});

/// True when a file is a trace that a `TraceRecorder` began.
[[nodiscard]] bool is_trace(const std::filesystem::path& file);

/// Description of the run in its trace.
struct TraceOrigin {
  std::string scenario{};                           ///< name of the scenario
  std::optional<std::int64_t> control_period_ns{};  ///< none in an event-exact run [ns]
  std::span<const ControlChannel> channels{};       ///< of the run's controller
  bool plant{true};  ///< false: the plant's true values are not known, and the group `plant` is left out
  /// Beginning of the run on the clock of its rows; none where it is not known before the first row [ns]
  std::optional<std::int64_t> begin_ns{0};
};

/// Writes a run to an HDF5 file while it goes on.
///
/// One dataset per signal, one row per interval, which ends at the row's `t_ns` and begins behind that of the
/// row before: means, minima and maxima are those of (t − interval, t], all other values those at t. So no
/// row has anything of after its time. With several rows a control period (`TraceDivider`) the drive's values
/// hold until its next one, and the plant's run linearly between switching instants. The root group holds the
/// members of `TelemetryIntervalRecord` under the names of configs/interfaces/telemetry.idl; the group
/// `plant` holds the plant's true values on the same rows, the group `control` the comparators' outputs and
/// the torque monitor's torque. Which of them are written is the choice of `TraceParameters::signals`. Every
/// dataset carries the attributes `unit` and `description`; the file carries `scenario`, `sextant_version`,
/// `mode`
/// (`sampled` or `event_exact`), `control_period_ns` if there is one, `interval_ns`, `begin_ns` and
/// `decimation`, which says what a row covers.
///
/// A sampled run gives its gate segments (`add_segment`) and control periods (`add`), an event-exact one
/// finished rows (`add_row`).
///
/// Rows are written about once a second of wall time, and the file is complete in itself after each time, so
/// that of an interrupted run all but the last second can be read.
class TraceRecorder {
 public:
  /// Called once, at the first error of writing; the default prints one line to standard error.
  using ErrorHandler = std::function<void(const std::string&)>;

  /// Creates the file, replacing one of that name. Throws std::runtime_error with file and reason if that
  /// fails or if there is a control period and the interval is neither a whole number nor a whole part of it.
  TraceRecorder(const std::filesystem::path& file, const TraceParameters& parameters,
                const TraceOrigin& origin, ErrorHandler on_error = {});
  ~TraceRecorder();  ///< closes
  TraceRecorder(TraceRecorder&&) noexcept;
  TraceRecorder& operator=(TraceRecorder&&) noexcept;

  /// Adds a gate segment of a sampled run: the plant at both of its ends, and its length [s]. Throws
  /// std::logic_error in an event-exact run.
  void add_segment(const PlantSample& before, const PlantSample& after, double seconds);

  /// Adds one control period of a sampled run, after its segments. After an error of writing this does
  /// nothing. Throws std::logic_error in an event-exact run.
  void add(const Telemetry<>& telemetry, const PlantSample& plant, const ControlSample& control = {});

  /// Adds a finished row. After an error of writing this does nothing.
  void add_row(const TraceRow& row);

  /// Writes all complete rows to the file.
  void flush();

  /// Writes what is left, the unfinished interval of `add` included (see its `periods`), and closes the
  /// file.
  void close();

  /// The first error of writing, with file and reason; empty while there was none.
  [[nodiscard]] const std::string& error() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sextant
