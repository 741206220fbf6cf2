#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

namespace sextant {

/// The figures by which a run is judged, in the order in which they are shown.
enum class Metric : std::uint8_t {
  torque_ripple_pp,
  torque_ripple_rms,
  torque_bias,
  response_time,
  flux_mean,
  flux_min,
  flux_max,
  switching_frequency,
  peak_current,
  current_thd,
  simulated,
  wall,
  realtime_factor
};

/// Name, unit and meaning of a metric.
struct MetricInfo {
  const char* name;
  const char* unit;
  const char* meaning;
};

inline constexpr std::size_t metric_count = 13;

/// Every metric, in the order of `Metric`. The names are those of summaries and of a scenario's `[expect]`.
inline constexpr std::array<MetricInfo, metric_count> metric_catalogue{{
    {"torque_ripple_pp_nm", "N·m", "largest minus smallest torque error in the window"},
    {"torque_ripple_rms_nm", "N·m", "RMS of the torque error about its mean in the window"},
    {"torque_bias_nm", "N·m", "mean torque error, torque minus reference, in the window"},
    {"response_time_ms", "ms", "from the step to the first sample at 95 % of it"},
    {"flux_mean_wb", "Wb", "mean stator flux magnitude in the window"},
    {"flux_min_wb", "Wb", "smallest stator flux magnitude in the window"},
    {"flux_max_wb", "Wb", "largest stator flux magnitude in the window"},
    {"switching_frequency_hz", "Hz",
     "turn-ons of an upper switch per second in the window, mean of the legs"},
    {"peak_current_a", "A", "largest phase current of the whole run"},
    {"current_thd_percent", "%", "current harmonics to fundamental in the window"},
    {"simulated_s", "s", "length of the run in the drive's time"},
    {"wall_s", "s", "length of the run in wall time"},
    {"realtime_factor", "1", "simulated time per wall time"},
}};

/// The metric of that name, if there is one.
[[nodiscard]] constexpr std::optional<Metric> find_metric(std::string_view name) noexcept {
  for (std::size_t k = 0; k < metric_count; ++k) {
    if (name == metric_catalogue[k].name) return static_cast<Metric>(k);
  }
  return std::nullopt;
}

[[nodiscard]] constexpr const MetricInfo& info(Metric m) noexcept {
  return metric_catalogue[static_cast<std::size_t>(m)];
}

/// A value for every metric, in catalogue order; NaN where the run gave none.
class MetricList {
 public:
  constexpr MetricList() noexcept { values_.fill(std::numeric_limits<double>::quiet_NaN()); }

  [[nodiscard]] constexpr double& operator[](Metric m) noexcept {
    return values_[static_cast<std::size_t>(m)];
  }
  [[nodiscard]] constexpr double operator[](Metric m) const noexcept {
    return values_[static_cast<std::size_t>(m)];
  }

  /// Values in the order of `metric_catalogue`.
  [[nodiscard]] constexpr const std::array<double, metric_count>& values() const noexcept { return values_; }

 private:
  std::array<double, metric_count> values_{};
};

}  // namespace sextant
