#include "reports/junit_file.hpp"

#include <cmath>
#include <cstddef>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "reports/junit_suite.hpp"
#include "sextant/files/replace_file.hpp"
#include "sextant/run/summary_text.hpp"

namespace sextant::reports {
namespace {

namespace fs = std::filesystem;

/// True where the first element of a file is one of JUnit's.
bool is_junit(const fs::path& file) {
  std::string beginning(4096, '\0');
  std::ifstream in{file, std::ios::binary};
  in.read(beginning.data(), std::ptrdiff_t(beginning.size()));
  beginning.resize(std::size_t(in.gcount()));
  // Text in front of the element is a node of a fragment; a document that is cut off keeps its first nodes.
  pugi::xml_document document;
  (void)document.load_buffer(beginning.data(), beginning.size(), pugi::parse_default | pugi::parse_fragment);
  const std::string_view name = document.first_child().name();
  return name == "testsuites" || name == "testsuite";
}

void refuse_other_content(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored) || fs::file_size(file, ignored) == 0 || is_junit(file)) return;
  throw std::runtime_error{file.string() +
                           " is there and is no JUnit file: move it, or name another file with --junit"};
}

void add_limit(JUnitSuite& suite, const ExpectationResult& result) {
  std::string name = result.limit.metric;
  if (result.window) name += ", " + window_text(*result.window);
  name += " " + limit_text(result.limit);
  const pugi::xml_node test = suite.add(name);
  if (result.pass) return;
  const std::string unit = unit_text(result.limit.metric);
  const std::string value = std::isfinite(result.value) ? fmt::format("{} {}", value_text(result.value), unit)
                                                        : std::string{"no value"};
  suite.fail(
      test, "limit",
      fmt::format("{} is {}, expected {} {}", result.limit.metric, value, limit_text(result.limit), unit));
}

void add_expected_fault(JUnitSuite& suite, const RunSummary& summary) {
  if (!summary.expected_fault) return;
  const FaultExpectation& expected = *summary.expected_fault;
  const pugi::xml_node test =
      suite.add(fmt::format("fault {}, {}", to_string(expected.fault), window_text(expected.window)));
  if (summary.faults_as_expected()) return;
  const std::string came = summary.faults.empty() ? std::string{"no fault came"}
                                                  : fmt::format("{} came first, at {:.6f} s",
                                                                to_string(summary.faults.front().fault),
                                                                in_seconds(summary.faults.front().t_ns));
  suite.fail(test, "fault", came);
}

void add_verdict(JUnitSuite& suite, const RunSummary& summary) {
  const pugi::xml_node test = suite.add("verdict", summary.metrics[Metric::wall]);
  const Verdict verdict = summary.verdict();
  if (verdict == Verdict::pass) return;
  const std::string reason = reason_text(summary);
  if (summary.status() == 0) {
    suite.skip(test, info(verdict).meaning);
    return;
  }
  if (verdict == Verdict::fail || verdict == Verdict::nothing_expected) {
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

JUnitFile::JUnitFile(fs::path file, const std::vector<std::string>& scenarios, const std::string& program)
    : file_{std::move(file)} {
  refuse_other_content(file_);
  pugi::xml_node root = document_.append_child("testsuites");
  append_attribute(root, "name", program);
  for (const char* count : junit_counts) root.append_attribute(count) = 0;
  append_attribute(root, "time", junit_seconds(0));
  for (const std::string& scenario : scenarios) {
    JUnitSuite suite{root.append_child("testsuite"), scenario, 0};
    suite.skip(suite.add("verdict"), "not run");
  }
  next_ = root.first_child();
  write();
}

void JUnitFile::add(const RunSummary& summary) {
  const double wall_s = summary.metrics[Metric::wall];
  JUnitSuite suite{next(), summary.scenario, wall_s};
  suite.add_property("version", summary.version);
  suite.add_property("commit", summary.commit);
  add_verdict(suite, summary);
  add_expected_fault(suite, summary);
  for (const ExpectationResult& result : summary.expectations) add_limit(suite, result);
  if (std::isfinite(wall_s)) time_s_ += wall_s;
  write();
}

void JUnitFile::add_error(const std::string& reason) {
  const pugi::xml_node node = next();
  JUnitSuite suite{node, std::string{node.attribute("name").value()}, 0};
  suite.error(suite.add("verdict"), "no_summary", reason);
  write();
}

pugi::xml_node JUnitFile::next() {
  return std::exchange(next_, next_.next_sibling());
}

void JUnitFile::write() {
  pugi::xml_node root = document_.document_element();
  for (const char* count : junit_counts) root.attribute(count) = sum(root, count);
  root.attribute("time") = junit_seconds(time_s_).c_str();
  std::ostringstream text;
  document_.save(text, "  ", pugi::format_default, pugi::encoding_utf8);
  replace_file(file_, text.str(), "the JUnit file");
}

}  // namespace sextant::reports
