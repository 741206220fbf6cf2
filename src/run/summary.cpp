#include "sextant/run/summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "sextant/files/replace_file.hpp"
#include "sextant/run/summary_text.hpp"

namespace sextant {
namespace {

using Json = nlohmann::ordered_json;

Json number(double x) {
  return std::isfinite(x) ? Json(x) : Json(nullptr);
}

Json limit_of(const Expectation& e) {
  Json limit = Json::object();
  if (e.min) limit["min"] = number(*e.min);
  if (e.max) limit["max"] = number(*e.max);
  return limit;
}

std::string coloured(bool good, const std::string& word, bool colour) {
  if (!colour) return word;
  return (good ? "\x1b[32m" : "\x1b[1;31m") + word + "\x1b[0m";
}

std::string pass_text(bool pass, bool colour) {
  return coloured(pass, pass ? "pass" : "FAIL", colour);
}

std::string verdict_text(const RunSummary& summary, bool colour) {
  const Verdict verdict = summary.verdict();
  std::string word{to_string(verdict)};
  if (verdict == Verdict::fail) word = "FAIL";
  std::replace(word.begin(), word.end(), '_', ' ');
  return coloured(summary.status() == 0, word, colour);
}

/// An end that is none is infinite, which JSON writes as null.
Json window_of(const TimeWindow& window) {
  const bool ends = window.to_ns != TimeWindow{}.to_ns;
  return {{"from_s", in_seconds(window.from_ns)}, {"to_s", ends ? Json(in_seconds(window.to_ns)) : Json()}};
}

Json expectation_of(const ExpectationResult& e) {
  Json row;
  row["metric"] = e.limit.metric;
  row["limit"] = limit_of(e.limit);
  row["value"] = number(e.value);
  row["pass"] = e.pass;
  if (e.window) row["window"] = window_of(*e.window);
  return row;
}

Json faults_of(const RunSummary& summary) {
  Json faults = Json::array();
  for (const LatchedFault& f : summary.faults)
    faults.push_back({{"fault", to_string(f.fault)}, {"t_s", in_seconds(f.t_ns)}});
  return faults;
}

Json expected_fault_of(const RunSummary& summary) {
  if (!summary.expected_fault) return {};
  Json expected = window_of(summary.expected_fault->window);
  expected["fault"] = to_string(summary.expected_fault->fault);
  expected["pass"] = summary.faults_as_expected();
  return expected;
}

void append_faults(std::string& text, const RunSummary& summary, bool colour) {
  for (const LatchedFault& f : summary.faults)
    text += fmt::format("  fault {} at {:.6f} s\n", to_string(f.fault), in_seconds(f.t_ns));
  if (!summary.expected_fault) return;
  const FaultExpectation& expected = *summary.expected_fault;
  text += fmt::format("  expected {}, {}  {}\n", to_string(expected.fault), window_text(expected.window),
                      pass_text(summary.faults_as_expected(), colour));
}

/// Limits over windows of their own.
void append_windows(std::string& text, const RunSummary& summary, bool colour) {
  for (const ExpectationResult& e : summary.expectations) {
    const std::optional<Metric> found = find_metric(e.limit.metric);
    if (!e.window || !found) continue;
    const MetricInfo& metric = info(*found);
    text += fmt::format("  {:<25} {:>11} {:<5}  {:<17} {}  {}\n", metric.name, value_text(e.value),
                        metric.unit, limit_text(e.limit), pass_text(e.pass, colour), window_text(*e.window));
  }
}

// A metric without expectations has one line, one with several a line for each.
void append_metric(std::string& text, const RunSummary& summary, std::size_t index, bool colour) {
  const MetricInfo& metric = metric_catalogue[index];
  const std::string value = value_text(summary.metrics.values()[index]);
  const auto line = fmt::format("  {:<25} {:>11} {:<5}", metric.name, value, metric.unit);
  bool demanded = false;
  for (const ExpectationResult& e : summary.expectations) {
    if (e.window || e.limit.metric != metric.name) continue;
    demanded = true;
    fmt::format_to(std::back_inserter(text), "{}  {:<17} {}\n", line, limit_text(e.limit),
                   pass_text(e.pass, colour));
  }
  if (!demanded) text += line + '\n';
}

}  // namespace

bool RunSummary::passed() const noexcept {
  return std::all_of(expectations.begin(), expectations.end(), [](const auto& e) { return e.pass; });
}

bool RunSummary::faults_as_expected() const noexcept {
  if (!expected_fault) return faults.empty();
  return !faults.empty() && faults.front().fault == expected_fault->fault &&
         expected_fault->window.contains(std::max<std::int64_t>(0, faults.front().t_ns));
}

Verdict RunSummary::verdict() const noexcept {
  if (stopped) return Verdict::interrupted;
  if (!plant_healthy) return Verdict::plant_failed;
  if (!faults.empty() && !faults_as_expected()) return Verdict::tripped;
  // A balance that is no number does not close.
  if (!(metrics[Metric::energy_unaccounted] <= largest_unaccounted)) return Verdict::not_balanced;
  if (!trace_error.empty()) return Verdict::trace_incomplete;
  // A drive that trips as expected owes nothing.
  if (missing_torque && !expected_fault) return Verdict::no_torque;
  if (cycle_departure && !expected_fault) return Verdict::not_followed;
  if (!expects_something()) return Verdict::nothing_expected;
  return passed() && faults_as_expected() ? Verdict::pass : Verdict::fail;
}

RunSummary summarise(const Scenario& scenario, const MilResult& result) {
  RunSummary summary{.scenario = scenario.name,
                     .metrics = result.metrics,
                     .expectations = evaluate(scenario.expectations, result.metrics),
                     .faults = result.fault_times,
                     .expected_fault = scenario.expected_fault,
                     .missing_torque = result.missing_torque,
                     .cycle_departure = result.cycle_departure,
                     .stopped = result.stopped,
                     .plant_healthy = result.plant_healthy};
  for (std::size_t k = 0; k < scenario.windows.size(); ++k) {
    for (ExpectationResult& outcome : evaluate(scenario.windows[k].limits, result.window_metrics.at(k))) {
      outcome.window = scenario.windows[k].window;
      summary.expectations.push_back(std::move(outcome));
    }
  }
  return summary;
}

std::string to_json(const RunSummary& summary) {
  Json json;
  json["scenario"] = summary.scenario;
  json["verdict"] = to_string(summary.verdict());
  json["metrics"] = Json::object();
  for (std::size_t k = 0; k < metric_count; ++k) {
    json["metrics"][metric_catalogue[k].name] = number(summary.metrics.values()[k]);
  }
  json["expect"] = Json::array();
  for (const ExpectationResult& e : summary.expectations) json["expect"].push_back(expectation_of(e));
  json["faults"] = faults_of(summary);
  json["expected_fault"] = expected_fault_of(summary);
  if (!summary.problem.empty()) json["problem"] = summary.problem;
  if (!summary.trace_error.empty()) json["trace_error"] = summary.trace_error;
  const Json configuration = Json::parse(summary.configuration, nullptr, false);
  if (!configuration.is_discarded()) json["configuration"] = configuration;
  if (!summary.version.empty()) json["version"] = summary.version;
  if (!summary.commit.empty()) json["commit"] = summary.commit;
  // A name that is not valid UTF-8 is replaced, not refused: it came from a file name at worst.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

void write_summary(const RunSummary& summary, const std::filesystem::path& file) {
  replace_file(file, to_json(summary), "the summary");
}

std::optional<std::string> scenario_of_summary(const std::filesystem::path& file) {
  std::ifstream in{file, std::ios::binary};
  const Json json = Json::parse(in, nullptr, false);
  if (!json.is_object() || !json.contains("metrics") || !json.contains("expect")) return std::nullopt;
  const auto scenario = json.find("scenario");
  if (scenario == json.end() || !scenario->is_string()) return std::nullopt;
  return scenario->get<std::string>();
}

std::string format_summary(const RunSummary& summary, bool colour) {
  std::string text = fmt::format("{}: {}\n", summary.scenario, verdict_text(summary, colour));
  append_faults(text, summary, colour);
  for (std::size_t k = 0; k < metric_count; ++k) append_metric(text, summary, k, colour);
  append_windows(text, summary, colour);
  return text;
}

void print_summary(const RunSummary& summary, std::FILE* out) {
  const bool colour = ::isatty(::fileno(out)) == 1 && std::getenv("NO_COLOR") == nullptr;
  const std::string text = format_summary(summary, colour);
  std::fwrite(text.data(), 1, text.size(), out);
}

}  // namespace sextant
