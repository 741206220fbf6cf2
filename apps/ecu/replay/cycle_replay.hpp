#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "ecu/telemetry/telemetry_file.hpp"
#include "ecu/unit/configured_drive.hpp"
#include "sextant/config/ecu_config.hpp"
#include "sextant/config/ecu_extensions.hpp"
#include "sextant/core/fault.hpp"
#include "sextant/core/telemetry_interval.hpp"
#include "sextant/recording/cycle_file.hpp"
#include "sextant/run/verdict.hpp"

namespace sextant::ecu {

/// Runs recorded measurements and commands through the drive again, from its start, and compares the gate
/// patterns. The same build with the recorded configuration answers bit for bit alike. With another
/// configuration the run shows what that drive would have answered; the measurements stay the recorded ones.
class CycleReplay {
 public:
  /// overrides: key=value, after the recorded configuration. own: as of load_ecu_config. telemetry_out: file
  /// of the replayed telemetry, empty for none. Throws std::runtime_error with one sentence where a file or a
  /// key cannot be used.
  CycleReplay(const std::string& file, const std::vector<std::string>& overrides, const EcuExtensions& own,
              const std::string& telemetry_out);

  void run();
  void print_report(std::FILE* out) const;
  /// `tripped` where the drive is in FAULT at the end, `fail` where a pattern differs from the recorded one,
  /// else `pass`.
  [[nodiscard]] Verdict verdict() const noexcept;
  /// Why the drive has tripped, in one sentence; empty where it has not.
  [[nodiscard]] std::string reason() const;

 private:
  struct Difference {
    std::uint64_t period{};
    std::int64_t t_ns{};
    GatePattern recorded{};
    GatePattern replayed{};
  };

  void require_recorded_period(const EcuExtensions& own) const;
  void step(const CycleRecord<double>& record);

  std::string file_;
  CycleFileReader reader_;
  bool is_changed_;
  EcuConfig config_;
  ConfiguredDrive drive_;
  std::optional<TelemetryFile> telemetry_{};
  TelemetryInterval<double> interval_{};
  std::uint64_t periods_{0};
  std::uint64_t different_{0};
  std::int64_t begin_ns_{0};
  std::int64_t end_ns_{0};
  std::optional<Difference> first_{};
  std::optional<Fault> tripped_{};  // the first fault that is latched in the last period
};

}  // namespace sextant::ecu
