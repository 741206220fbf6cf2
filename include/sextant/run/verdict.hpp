#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace sextant {

/// How a run turned out. The first that applies counts.
enum class Verdict : std::uint8_t {
  interrupted,
  plant_failed,
  tripped,
  not_balanced,
  trace_incomplete,
  no_torque,
  not_followed,
  fail,
  nothing_expected,
  pass
};

/// Word, exit status and meaning of a verdict.
struct VerdictInfo {
  const char* word;     ///< in summaries
  int status;           ///< of a program whose run turned out so; `interrupted`: to it the signal is added
  const char* meaning;  ///< for people
};

/// Every verdict, in the order of `Verdict`. Programs, their help and the pages have words and statuses from
/// here. A run that cannot be begun has no verdict, and status 2 (apps/common/exit_status.hpp).
inline constexpr std::array<VerdictInfo, 10> verdict_catalogue{{
    {"interrupted", 128, "ended by SIGINT or SIGTERM, whose number is added to the status"},
    {"plant_failed", 6, "the integration of the plant failed"},
    {"tripped", 3, "a fault latched that was not expected"},
    {"not_balanced", 7, "more than 1e-4 of the energy is unaccounted for"},
    {"trace_incomplete", 8, "the trace could not be written to its end"},
    {"no_torque", 4, "torque was asked and never made"},
    {"not_followed", 5, "the vehicle did not follow the speed of its cycle"},
    {"fail", 1, "a limit of [expect] does not hold, or the expected fault did not come"},
    {"nothing_expected", 0, "it ran, and nothing was expected of it"},
    {"pass", 0, "everything that was expected holds"},
}};

/// Status of a run without an expectation where one is required.
inline constexpr int expectation_missing_status = 9;

[[nodiscard]] constexpr const VerdictInfo& info(Verdict verdict) noexcept {
  return verdict_catalogue[static_cast<std::size_t>(verdict)];
}

/// The word in summaries: `pass`, `not_balanced`, …
[[nodiscard]] constexpr const char* to_string(Verdict verdict) noexcept {
  return info(verdict).word;
}

/// Exit status of a run. `is_expectation_required`: a run of which nothing is expected counts as a failure.
[[nodiscard]] constexpr int exit_status(Verdict verdict, bool is_expectation_required = false) noexcept {
  if (verdict == Verdict::nothing_expected && is_expectation_required) return expectation_missing_status;
  return info(verdict).status;
}

}  // namespace sextant
