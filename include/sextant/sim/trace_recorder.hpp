#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "sextant/core/space_vector.hpp"
#include "sextant/core/telemetry.hpp"

namespace sextant {

struct TraceParameters {
  double interval_us{1000};  ///< one row of the trace, a whole number of control periods [µs]
  int compression{0};        ///< deflate level 0 to 9; 1 writes a quarter of the bytes in twice the time [-]

  [[nodiscard]] const char* validate() const noexcept {
    if (!std::isfinite(interval_us) || interval_us <= 0)
      return "the trace interval must be finite and above zero";
    if (interval_us > 1e9) return "the trace interval must be at most 1000 s";
    if (compression < 0 || compression > 9) return "the trace compression must be between 0 and 9";
    return nullptr;
  }
};

/// What a trace says of the run it belongs to.
struct TraceOrigin {
  std::string scenario{};            ///< name of the scenario
  std::int64_t control_period_ns{};  ///< [ns]
};

/// The true values of the plant, at the instant of the telemetry they are recorded with.
struct PlantSample {
  double torque{};        ///< air-gap torque [N·m]
  double tau_l{};         ///< load torque [N·m]
  SpaceVector<> psi_s{};  ///< stator flux linkage, stationary frame [Wb]
  SpaceVector<> psi_r{};  ///< rotor flux linkage, stationary frame [Wb]
  ThreePhase<> i_abc{};   ///< phase currents, positive into the machine [A]
  double u_dc{};          ///< DC-link voltage [V]
  double omega_m{};       ///< mechanical speed [rad/s]
};

/// Writes a run to an HDF5 file while it goes on.
///
/// One dataset per signal, one row per interval. The root group holds the members of
/// `TelemetryIntervalRecord` under the names of configs/interfaces/telemetry.idl; the group `plant` holds the
/// plant's true values on the same rows. Every dataset carries the attributes `unit` and `description`;
/// the file carries `scenario`, `sextant_version`, `control_period_ns` and `interval_ns`.
///
/// Rows are written about once a second of wall time, and the file is complete in itself after each time, so
/// that of an interrupted run all but the last second can be read.
class TraceRecorder {
 public:
  /// Told once, at the first error of writing; the default prints one line to standard error.
  using ErrorHandler = std::function<void(const std::string&)>;

  /// Creates the file, replacing one of that name. Throws std::runtime_error with file and reason if that
  /// fails or if the interval is not a whole number of control periods.
  TraceRecorder(const std::filesystem::path& file, const TraceParameters& parameters,
                const TraceOrigin& origin, ErrorHandler on_error = {});
  ~TraceRecorder();  ///< closes
  TraceRecorder(TraceRecorder&&) noexcept;
  TraceRecorder& operator=(TraceRecorder&&) noexcept;

  /// Adds one control period. After an error of writing this does nothing.
  void add(const Telemetry<>& telemetry, const PlantSample& plant);

  /// Writes all complete rows to the file.
  void flush();

  /// Writes what is left, the unfinished interval included (its `periods` tells), and closes the file.
  void close();

  /// The first error of writing, with file and reason; empty while there was none.
  [[nodiscard]] const std::string& error() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sextant
