#include "sextant/config/scenario_config.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

namespace sextant {
namespace {

constexpr double ns_per_s = 1e9;
constexpr Range<double> time_s{0, 1e6};

std::int64_t to_ns(double s) {
  return std::llround(s * ns_per_s);
}

void describe(Section s, MetricsParameters& p) {
  constexpr std::int64_t end = std::numeric_limits<std::int64_t>::max();
  s.time("window_from_s", p.from_ns, ns_per_s, time_s, "s", "beginning of the window of steady metrics");
  s.add("window_to_s", "s", "end of that window; not set: the end of the run",
        NumberField{time_s,
                    [&p]() -> std::optional<double> {
                      if (p.to_ns == end) return std::nullopt;
                      return static_cast<double>(p.to_ns) / ns_per_s;
                    },
                    [&p](double x) { p.to_ns = to_ns(x); }});
  s.add("step_s", "s", "instant of the torque step whose response time is taken",
        NumberField{time_s,
                    [&p]() -> std::optional<double> {
                      if (!p.step_ns) return std::nullopt;
                      return static_cast<double>(*p.step_ns) / ns_per_s;
                    },
                    [&p](double x) { p.step_ns = to_ns(x); }});
  s.check(p);
}

/// One bound of one metric; the list has an entry for each metric that has a bound, in catalogue order.
void bound(Section& s, std::vector<Expectation>& list, Metric metric, const char* key,
           std::optional<double> Expectation::* member) {
  constexpr Range<double> any{-1e12, 1e12};
  const std::string name = info(metric).name;
  const auto find = [&list, name] {
    return std::find_if(list.begin(), list.end(), [&name](const Expectation& e) { return e.metric == name; });
  };
  const auto get = [&list, find, member]() -> std::optional<double> {
    const auto entry = find();
    return entry == list.end() ? std::nullopt : (*entry).*member;
  };
  const auto set = [&list, find, member, name, metric](double x) {
    auto entry = find();
    if (entry == list.end()) {
      const auto next = std::find_if(list.begin(), list.end(), [metric](const Expectation& e) {
        return find_metric(e.metric).value_or(metric) > metric;
      });
      entry = list.insert(next, Expectation{name, {}, {}});
    }
    (*entry).*member = x;
  };
  s.add(key, info(metric).unit, info(metric).meaning, NumberField{any, get, set});
}

void describe(Section s, std::vector<Expectation>& list) {
  for (std::size_t k = 0; k < metric_count; ++k) {
    const auto metric = static_cast<Metric>(k);
    Section entry = s.section(info(metric).name);
    bound(entry, list, metric, "min", &Expectation::min);
    bound(entry, list, metric, "max", &Expectation::max);
  }
  s.check([&list]() -> std::string {
    for (const Expectation& e : list) {
      if (std::string problem = e.validate(); !problem.empty()) return problem;
    }
    return {};
  });
}

/// What holds between the parts of a run.
std::string validate(const Scenario& scenario, std::int64_t period_ns) {
  const auto demands_response = [](const Expectation& e) {
    return find_metric(e.metric) == Metric::response_time;
  };
  const MetricsParameters& m = scenario.metrics;
  if (scenario.duration_ns < period_ns) return "the run must last at least one control period";
  if (m.from_ns >= scenario.duration_ns) return "the window of the metrics begins after the run has ended";
  if (m.step_ns && *m.step_ns >= scenario.duration_ns)
    return "the step of the metrics comes after the run has ended";
  if (!m.step_ns &&
      std::any_of(scenario.expectations.begin(), scenario.expectations.end(), demands_response)) {
    return "a response time is expected, but metrics.step_s does not say from when";
  }
  const double periods = scenario.trace.interval_us * 1e3 / static_cast<double>(period_ns);
  if (periods < 0.5 || std::abs(periods - std::round(periods)) > 1e-9 * periods) {
    return "trace.interval_us must be a whole number of control periods";
  }
  return {};
}

}  // namespace

void describe(Section root, ScenarioConfig& c) {
  Scenario& scenario = c.scenario;
  root.text("name", scenario.name, "short name of the run");
  root.required();
  root.text("description", scenario.description, "what the run shows", true);
  root.time("duration_s", scenario.duration_ns, ns_per_s, {1e-6, 1e6}, "s", "length of the run");
  root.required();
  describe(root, c.drive);
  root.derive([&c] { c.scenario.load = c.drive.load.parameters(); });

  describe(root.section("profile").section("torque_nm"), scenario.torque_reference, "N·m", {-1e5, 1e5});
  describe(root.section("metrics"), scenario.metrics);
  Section trace = root.section("trace");
  trace.number("interval_us", scenario.trace.interval_us, {1, 1e9}, "us", "one row of the trace");
  trace.check(scenario.trace);
  describe(root.section("expect"), scenario.expectations);
  root.check([&c] { return validate(c.scenario, c.drive.direct_torque.period_ns); });
}

}  // namespace sextant
