#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "sextant/comms/telemetry_samples.hpp"
#include "sextant/comms/waveform_batch.hpp"
#include "sextant/core/telemetry_interval.hpp"

namespace sextant {

enum class DdsWrite : std::uint8_t {
  ok,
  refused,  ///< a value is NaN or infinite; nothing was published, readers see a gap in `sequence`
  failed    ///< DDS reported an error
};

/// Since start. [-]
struct DdsTelemetryCounts {
  std::uint64_t written{};
  std::uint64_t refused{};
  std::uint64_t failed{};
};

/// Publishes the topics of configs/interfaces/telemetry.idl for one drive. Every writer keeps the last sample
/// only, so that a reader that stopped never blocks it.
class DdsTelemetry {
 public:
  struct Parameters {
    std::uint32_t domain_id{0};  ///< DDS domain, 0 to 230 [-]
    std::uint32_t drive_id{1};   ///< key of every sample [-]
    /// Cyclone DDS configuration: XML, or a URI such as file:///etc/sextant/cyclonedds.xml. Empty: that of
    /// the environment (CYCLONEDDS_URI).
    std::string configuration{};
    /// Source of the configuration, for the message when DDS cannot start.
    std::string configuration_source{};
    /// Announces the types: readers can fetch them, and a reader with another type is not matched. Without,
    /// readers are matched by the name of the type; Cyclone DDS 0.10.2 then fetches no reader's type, which
    /// would crash it where that holds an int8 or uint8 (docs/telemetry.md, publisher).
    bool type_information{true};

    [[nodiscard]] const char* validate() const noexcept {
      return domain_id > 230 ? "the DDS domain must be from 0 to 230" : nullptr;
    }
  };

  /// Opens the topics. Throws std::runtime_error with one sentence where DDS cannot start.
  explicit DdsTelemetry(const Parameters& parameters);

  /// A further drive of the same process, with the domain and the participant of `first`, which may end
  /// before it. Not concurrently with another constructor or destructor. Throws std::runtime_error with one
  /// sentence where DDS cannot start or the process already publishes a drive of this id.
  DdsTelemetry(const DdsTelemetry& first, std::uint32_t drive_id);
  DdsTelemetry(const DdsTelemetry&) = delete;
  DdsTelemetry& operator=(const DdsTelemetry&) = delete;
  ~DdsTelemetry();

  /// Publishes an interval, without allocating. `dropped`: control periods lost before this call since
  /// start. `sequence`: number of the sample in its topic; without it the writer counts.
  DdsWrite write(const TelemetryIntervalRecord<double>& record, std::uint64_t dropped,
                 std::optional<std::uint64_t> sequence = {}) noexcept;
  DdsWrite write(const DriveStateSample& sample, std::optional<std::uint64_t> sequence = {}) noexcept;
  DdsWrite write(const RealTimeSample& sample, std::optional<std::uint64_t> sequence = {}) noexcept;
  /// Publishes consecutive control periods, without copying them. NaN is published as it is.
  DdsWrite write(const WaveformBatch& batch, std::uint64_t dropped,
                 std::optional<std::uint64_t> sequence = {}) noexcept;

  [[nodiscard]] DdsTelemetryCounts counts() const noexcept;

  /// Readers of DriveTelemetry that are matched now. [-]
  [[nodiscard]] std::uint32_t readers() const noexcept;

  /// Readers of DriveWaveform that are matched now. [-]
  [[nodiscard]] std::uint32_t waveform_readers() const noexcept;

  /// Readers of any topic that requested a quality of service that is not offered, since start. Such a reader
  /// gets no samples and no error. [-]
  [[nodiscard]] std::uint32_t incompatible_readers() const noexcept;

 private:
  struct Session;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sextant
