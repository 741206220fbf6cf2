#include "mil/junit_file.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "sextant/files/replace_file.hpp"
#include "sextant/sim/summary_text.hpp"

namespace sextant::mil {
namespace {

/// A text that XML 1.0 can hold: of the control characters it has three only.
std::string xml_text(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](unsigned char c) { return c < 0x20 && c != '\t' && c != '\n' && c != '\r'; }, '?');
  return text;
}

void set(pugi::xml_node node, const char* name, const std::string& text) {
  node.append_attribute(name).set_value(xml_text(text).c_str());
}

std::string seconds(double time_s) {
  return fmt::format("{:.6f}", std::isfinite(time_s) ? time_s : 0.0);
}

/// One suite while its cases are added.
class Suite {
 public:
  Suite(pugi::xml_node root, const RunSummary& summary) : node_{root.append_child("testsuite")} {
    set(node_, "name", summary.scenario);
    for (const char* count : {"tests", "failures", "errors", "skipped"}) node_.append_attribute(count) = 0;
    set(node_, "time", seconds(summary.metrics[Metric::wall]));
    pugi::xml_node properties = node_.append_child("properties");
    for (const auto& [name, value] : {std::pair{"version", summary.version}, {"commit", summary.commit}}) {
      pugi::xml_node property = properties.append_child("property");
      set(property, "name", name);
      set(property, "value", value);
    }
  }

  pugi::xml_node add(const std::string& name, double time_s = 0) {
    pugi::xml_node test = node_.append_child("testcase");
    set(test, "classname", node_.attribute("name").value());
    set(test, "name", name);
    set(test, "time", seconds(time_s));
    count("tests");
    return test;
  }

  void fail(pugi::xml_node test, const std::string& type, const std::string& message) {
    report(test, "failure", "failures", type, message);
  }

  void error(pugi::xml_node test, const std::string& type, const std::string& message) {
    report(test, "error", "errors", type, message);
  }

 private:
  void count(const char* name) {
    pugi::xml_attribute attribute = node_.attribute(name);
    attribute = attribute.as_int() + 1;
  }

  void report(pugi::xml_node test, const char* kind, const char* counter, const std::string& type,
              const std::string& message) {
    pugi::xml_node result = test.append_child(kind);
    set(result, "type", type);
    set(result, "message", message);
    count(counter);
  }

  pugi::xml_node node_;
};

std::string unit_of(const std::string& metric) {
  const std::optional<Metric> found = find_metric(metric);
  return found ? info(*found).unit : "";
}

void add_limit(Suite& suite, const ExpectationResult& result) {
  std::string name = result.limit.metric;
  if (result.window) name += ", " + window_text(*result.window);
  name += " " + limit_text(result.limit);
  const pugi::xml_node test = suite.add(name);
  if (result.pass) return;
  const std::string value = std::isfinite(result.value)
                                ? fmt::format("{} {}", value_text(result.value), unit_of(result.limit.metric))
                                : std::string{"no value"};
  suite.fail(test, "limit",
             fmt::format("{} is {}, expected {} {}", result.limit.metric, value, limit_text(result.limit),
                         unit_of(result.limit.metric)));
}

void add_expected_fault(Suite& suite, const RunSummary& summary) {
  if (!summary.expected_fault) return;
  const FaultExpectation& expected = *summary.expected_fault;
  const pugi::xml_node test =
      suite.add(fmt::format("fault {}, {}", to_string(expected.fault), window_text(expected.window)));
  if (summary.faults_as_expected()) return;
  const std::string came = summary.faults.empty() ? std::string{"no fault came"}
                                                  : fmt::format("{} came first, at {:.6f} s",
                                                                to_string(summary.faults.front().fault),
                                                                double(summary.faults.front().t_ns) / 1e9);
  suite.fail(test, "fault", came);
}

void add_verdict(Suite& suite, const RunSummary& summary) {
  const pugi::xml_node test = suite.add("verdict", summary.metrics[Metric::wall]);
  const Verdict verdict = summary.verdict();
  if (verdict == Verdict::pass) return;
  const std::string reason = reason_text(summary);
  if (verdict == Verdict::fail) {
    suite.fail(test, to_string(verdict), reason.empty() ? "a limit does not hold" : reason);
  } else {
    suite.error(test, to_string(verdict), reason.empty() ? to_string(verdict) : reason);
  }
}

int sum(pugi::xml_node root, const char* name) {
  int total = 0;
  for (const pugi::xml_node suite : root.children("testsuite")) total += suite.attribute(name).as_int();
  return total;
}

}  // namespace

JUnitFile::JUnitFile(std::filesystem::path file) : file_{std::move(file)} {
  pugi::xml_node root = document_.append_child("testsuites");
  set(root, "name", "sextant-mil");
  for (const char* count : {"tests", "failures", "errors", "skipped"}) root.append_attribute(count) = 0;
  set(root, "time", seconds(0));
  if (file_.has_parent_path()) {
    std::error_code ignored;  // the file cannot be written then, which is reported
    std::filesystem::create_directories(file_.parent_path(), ignored);
  }
  write();
}

void JUnitFile::add(const RunSummary& summary) {
  pugi::xml_node root = document_.document_element();
  Suite suite{root, summary};
  add_verdict(suite, summary);
  add_expected_fault(suite, summary);
  for (const ExpectationResult& result : summary.expectations) add_limit(suite, result);
  for (const char* count : {"tests", "failures", "errors", "skipped"})
    root.attribute(count) = sum(root, count);
  const double wall_s = summary.metrics[Metric::wall];
  if (std::isfinite(wall_s)) time_s_ += wall_s;
  root.attribute("time") = seconds(time_s_).c_str();
  write();
}

void JUnitFile::write() {
  std::ostringstream text;
  document_.save(text, "  ", pugi::format_default, pugi::encoding_utf8);
  replace_file(file_, text.str(), "the JUnit file");
}

}  // namespace sextant::mil
