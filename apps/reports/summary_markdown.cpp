#include "reports/summary_markdown.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

#include "sextant/run/summary_text.hpp"

namespace sextant::reports {
namespace {

/// A text that is shown as it is: neither markup nor a new cell.
std::string plain(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (std::string_view{"\\`*_{}[]<>#|"}.find(c) != std::string_view::npos) escaped += '\\';
    escaped += c == '\n' ? ' ' : c;
  }
  return escaped;
}

/// A paragraph: each line of a text stays one, by the two spaces at its end.
std::string paragraph(const std::string& text) {
  std::string shown;
  std::istringstream lines{text};
  for (std::string line; std::getline(lines, line);) shown += (shown.empty() ? "" : "  \n") + plain(line);
  return shown + "\n\n";
}

std::string heading(const std::string& scenario, const std::string& verdict) {
  return fmt::format("### {}: {}\n\n", plain(scenario), plain(verdict));
}

std::string metric_cell(const ExpectationResult& result) {
  const std::string window = result.window ? ", " + window_text(*result.window) : "";
  return fmt::format("`{}`{}", result.limit.metric, window);
}

void append_limits(std::string& text, const RunSummary& summary) {
  if (summary.expectations.empty()) return;
  text += "| metric | value | unit | limit | |\n|---|---:|---|---|---|\n";
  for (const ExpectationResult& result : summary.expectations) {
    text += fmt::format("| {} | {} | {} | {} | {} |\n", metric_cell(result), value_text(result.value),
                        unit_text(result.limit.metric), limit_text(result.limit),
                        result.pass ? "pass" : "**FAIL**");
  }
  text += '\n';
}

bool has_limit(const RunSummary& summary, const char* metric) {
  return std::any_of(summary.expectations.begin(), summary.expectations.end(),
                     [&](const auto& e) { return !e.window && e.limit.metric == metric; });
}

void append_metrics(std::string& text, const RunSummary& summary) {
  text +=
      "<details><summary>metrics without a limit</summary>\n\n| metric | value | unit |\n|---|---:|---|\n";
  for (std::size_t k = 0; k < metric_count; ++k) {
    const MetricInfo& metric = metric_catalogue[k];
    if (has_limit(summary, metric.name)) continue;
    text += fmt::format("| `{}` | {} | {} |\n", metric.name, value_text(summary.metrics.values()[k]),
                        metric.unit);
  }
  text += "\n</details>\n\n";
}

[[noreturn]] void fail(const std::filesystem::path& file) {
  throw std::runtime_error{
      fmt::format("{}: cannot write the Markdown summary: {}", file.string(), std::strerror(errno))};
}

}  // namespace

std::string to_markdown(const RunSummary& summary) {
  std::string text = heading(summary.scenario, to_string(summary.verdict()));
  if (const std::string reason = reason_text(summary); !reason.empty()) text += paragraph(reason);
  for (const LatchedFault& latched : summary.faults)
    text += fmt::format("- fault `{}` at {:.6f} s\n", to_string(latched.fault), in_seconds(latched.t_ns));
  if (!summary.faults.empty()) text += '\n';
  append_limits(text, summary);
  append_metrics(text, summary);
  return text;
}

std::string error_markdown(const std::string& scenario, const std::string& reason) {
  return heading(scenario, "error") + paragraph(reason);
}

void append_markdown(const std::filesystem::path& file, const std::string& text) {
  errno = 0;
  std::ofstream out{file, std::ios::binary | std::ios::app};
  if (!out) fail(file);
  out << text;
  out.close();
  if (!out) fail(file);
}

}  // namespace sextant::reports
