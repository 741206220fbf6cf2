#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "ecu/parameters/parameter_changes.hpp"
#include "ecu/virtual_time/timed_override.hpp"
#include "sextant/virtual_time/virtual_clock.hpp"
#include "sextant/virtual_time/virtual_timeline.hpp"

namespace sextant::ecu {

/// Changes of a drive's parameters at instants of virtual time.
class TimedChanges {
 public:
  /// Those of `at` that count for the drive; of one instant they are one set. Clock and changes are not owned
  /// and must outlive this object. prefix: of its sentences, where there are several drives: "drive 2: ".
  TimedChanges(const std::vector<TimedOverride>& at, ParameterChanges& changes, const VirtualClock& clock,
               std::string prefix);

  /// Its part of the run, which throws std::runtime_error with a sentence where a set is refused.
  [[nodiscard]] VirtualParty party();

  /// After the run: throws std::runtime_error with a sentence where a set has not been taken by its end.
  void require_all() const;

  /// What the drive has taken, a line for each set.
  [[nodiscard]] const std::vector<std::string>& report() const noexcept { return report_; }

 private:
  struct Set {
    std::int64_t t_ns{};
    std::vector<std::string> overrides{};
  };

  void act();
  void offer(const Set& set);
  void look(const Set& set);
  [[noreturn]] void refuse(std::int64_t t_ns, const std::string& why) const;

  ParameterChanges& changes_;
  const VirtualClock& clock_;
  std::string prefix_;
  std::vector<Set> sets_{};
  std::size_t next_{0};
  bool waits_{false};
  std::int64_t due_ns_{};
  std::int64_t offered_ns_{};  ///< when the present set was offered
  std::vector<std::string> report_{};
};

}  // namespace sextant::ecu
