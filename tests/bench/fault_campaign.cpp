// One injection of the fault campaign over seeds, operating points and sensors. Without arguments: the list
// of injections. With INDEX SEEDS: a line of JSON.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "virtual_time/fault_injections.hpp"
#include "virtual_time/injection_run.hpp"

namespace sextant::test {
namespace {

/// What became of one injection in all its runs.
struct Tally {
  int runs{0};
  int missed{0};
  int late{0};               ///< raised, but later than the bound
  int before_observable{0};  ///< raised before the cause was observable
  int trips_inside{0};       ///< of the runs just inside the limit
  int runs_inside{0};
  std::int64_t reaction_ns{0};     ///< worst [ns]
  std::int64_t since_cause_ns{0};  ///< worst [ns]
  std::string worst{};             ///< case of the worst reaction, or of the first miss
};

void run(const Injection& injection, const InjectionPlan& plan, Tally& tally) {
  const CampaignCase c = prepared(injection, plan);
  VirtualRig rig{c.rig};
  const InjectionResult result = run_injection(injection, c, rig);
  if (plan.just_inside) {
    ++tally.runs_inside;
    tally.trips_inside += result.started && !result.raised ? 0 : 1;
    return;
  }
  const bool good = result.is_reaction();
  ++tally.runs;
  if (!good && tally.missed == 0) tally.worst = c.text();
  if (good && tally.missed == 0 && result.reaction_ns > tally.reaction_ns) tally.worst = c.text();
  tally.missed += good ? 0 : 1;
  tally.late += result.reaction_ns > injection.bound_ns ? 1 : 0;
  tally.before_observable += result.raised && !result.shown ? 1 : 0;
  tally.reaction_ns = std::max(tally.reaction_ns, result.reaction_ns);
  tally.since_cause_ns = std::max(tally.since_cause_ns, result.since_cause_ns);
}

Tally run_all(const Injection& injection, std::uint64_t seeds) {
  Tally tally;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    for (std::size_t point = 0; point < injection.points.size(); ++point) {
      for (const bool real_sensors : {false, true}) {
        run(injection, {.seed = seed, .point = point, .real_sensors = real_sensors}, tally);
        if (!injection.has_inside) continue;
        run(injection, {.seed = seed, .point = point, .real_sensors = real_sensors, .just_inside = true},
            tally);
      }
    }
  }
  return tally;
}

nlohmann::json line_of(const Injection& injection, const Tally& tally) {
  nlohmann::json points = nlohmann::json::array();
  for (const OperatingPoint& p : injection.points) points.push_back({p.omega_m, p.torque});
  return {{"name", injection.name},
          {"fault", to_string(injection.fault)},
          {"observable", injection.observable},
          {"points", points},
          {"bound_ms", double(injection.bound_ns) * 1e-6},
          {"runs", tally.runs},
          {"missed", tally.missed},
          {"late", tally.late},
          {"before_observable", tally.before_observable},
          {"reaction_ms", double(tally.reaction_ns) * 1e-6},
          {"since_cause_ms", double(tally.since_cause_ns) * 1e-6},
          {"runs_inside", tally.runs_inside},
          {"trips_inside", tally.trips_inside},
          {"worst", tally.worst}};
}

int main_of(const std::vector<std::string>& arguments) {
  const std::vector<Injection> list = fault_injections();
  if (arguments.empty()) {
    for (const Injection& injection : list) std::puts(injection.name.c_str());
    return 0;
  }
  if (arguments.size() != 2) return 2;
  const Injection& injection = list.at(std::stoul(arguments[0]));
  std::puts(line_of(injection, run_all(injection, std::stoul(arguments[1]))).dump().c_str());
  return 0;
}

}  // namespace
}  // namespace sextant::test

int main(int count, char** words) {
  return sextant::test::main_of({words + 1, words + count});
}
