#include "mil/run_reports.hpp"

#include <utility>

#include "mil/summary_markdown.hpp"

namespace sextant::mil {

RunReports::RunReports(const std::filesystem::path& junit, std::filesystem::path markdown)
    : markdown_{std::move(markdown)} {
  if (!junit.empty()) junit_.emplace(junit);
  if (!markdown_.empty()) append_markdown(markdown_, "");
}

void RunReports::add(const RunSummary& summary) {
  if (junit_) junit_->add(summary);
  if (!markdown_.empty()) append_markdown(markdown_, to_markdown(summary));
}

}  // namespace sextant::mil
