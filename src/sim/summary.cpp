#include "sextant/sim/summary.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

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

std::string limit_text(const Expectation& e) {
  if (e.min && e.max) return fmt::format("{:g} … {:g}", *e.min, *e.max);
  if (e.min) return fmt::format("≥ {:g}", *e.min);
  if (e.max) return fmt::format("≤ {:g}", *e.max);
  return "";
}

std::string value_text(double x) {
  return std::isfinite(x) ? fmt::format("{:.5g}", x) : std::string{"-"};
}

const char* verdict(bool pass, bool colour) {
  if (!colour) return pass ? "pass" : "FAIL";
  return pass ? "\x1b[32mpass\x1b[0m" : "\x1b[1;31mFAIL\x1b[0m";
}

// A metric without expectations has one line, one with several a line for each.
void append_metric(std::string& text, const RunSummary& summary, std::size_t index, bool colour) {
  const MetricInfo& metric = metric_catalogue[index];
  const std::string value = value_text(summary.metrics.values()[index]);
  const auto line = fmt::format("  {:<25} {:>11} {:<5}", metric.name, value, metric.unit);
  bool demanded = false;
  for (const ExpectationResult& e : summary.expectations) {
    if (e.limit.metric != metric.name) continue;
    demanded = true;
    fmt::format_to(std::back_inserter(text), "{}  {:<17} {}\n", line, limit_text(e.limit),
                   verdict(e.pass, colour));
  }
  if (!demanded) text += line + '\n';
}

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& reason) {
  throw std::runtime_error{fmt::format("{}: cannot write the summary: {}", file.string(), reason)};
}

}  // namespace

bool RunSummary::passed() const noexcept {
  return std::all_of(expectations.begin(), expectations.end(), [](const auto& e) { return e.pass; });
}

std::string to_json(const RunSummary& summary) {
  Json json;
  json["scenario"] = summary.scenario;
  json["metrics"] = Json::object();
  for (std::size_t k = 0; k < metric_count; ++k) {
    json["metrics"][metric_catalogue[k].name] = number(summary.metrics.values()[k]);
  }
  json["expect"] = Json::array();
  for (const ExpectationResult& e : summary.expectations) {
    Json row;
    row["metric"] = e.limit.metric;
    row["limit"] = limit_of(e.limit);
    row["value"] = number(e.value);
    row["pass"] = e.pass;
    json["expect"].push_back(std::move(row));
  }
  // A name that is not valid UTF-8 is replaced, not refused: it came from a file name at worst.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

void write_summary(const RunSummary& summary, const std::filesystem::path& file) {
  const std::string json = to_json(summary);
  std::filesystem::path part = file;
  part += fmt::format(".{}.part", ::getpid());
  std::error_code ignored;
  errno = 0;
  std::ofstream out{part, std::ios::binary | std::ios::trunc};
  if (!out) fail(file, std::strerror(errno));
  out << json;
  out.close();
  if (!out) {
    const std::string reason = std::strerror(errno);
    std::filesystem::remove(part, ignored);
    fail(file, reason);
  }
  std::error_code error;
  std::filesystem::rename(part, file, error);
  if (error) {
    std::filesystem::remove(part, ignored);
    fail(file, error.message());
  }
}

std::string format_summary(const RunSummary& summary, bool colour) {
  std::string text = fmt::format("{}: {}\n", summary.scenario, verdict(summary.passed(), colour));
  for (std::size_t k = 0; k < metric_count; ++k) append_metric(text, summary, k, colour);
  return text;
}

void print_summary(const RunSummary& summary, std::FILE* out) {
  const bool colour = ::isatty(::fileno(out)) == 1 && std::getenv("NO_COLOR") == nullptr;
  const std::string text = format_summary(summary, colour);
  std::fwrite(text.data(), 1, text.size(), out);
}

}  // namespace sextant
