#include "reports/run_reports.hpp"

#include <stdexcept>
#include <system_error>

#include "reports/summary_markdown.hpp"
#include "sextant/files/resolved_path.hpp"

namespace sextant::reports {
namespace {

void make_directory_of(const std::filesystem::path& file) {
  if (!file.has_parent_path()) return;
  std::error_code ignored;  // the file cannot be written then, which is reported
  std::filesystem::create_directories(file.parent_path(), ignored);
}

}  // namespace

RunReports::RunReports(const ReportOptions& files, const std::vector<std::string>& scenarios,
                       const std::string& program)
    : markdown_{files.summary_markdown} {
  const std::filesystem::path& junit = files.junit;
  if (!junit.empty() && !markdown_.empty() && resolved_path(junit) == resolved_path(markdown_)) {
    throw std::runtime_error{junit.string() +
                             ": --junit and --summary-markdown name the same file: name two files"};
  }
  make_directory_of(junit);
  make_directory_of(markdown_);
  if (!junit.empty()) junit_.emplace(junit, scenarios, program);
  if (!markdown_.empty()) append_markdown(markdown_, "");
}

void RunReports::add(const RunSummary& summary) {
  if (junit_) junit_->add(summary);
  if (!markdown_.empty()) append_markdown(markdown_, to_markdown(summary));
}

void RunReports::add_error(const std::string& scenario, const std::string& reason) {
  if (junit_) junit_->add_error(reason);
  if (!markdown_.empty()) append_markdown(markdown_, error_markdown(scenario, reason));
}

}  // namespace sextant::reports
