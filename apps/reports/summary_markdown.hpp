#pragma once

#include <filesystem>
#include <string>

#include "sextant/run/summary.hpp"

namespace sextant::reports {

/// The run as Markdown, as GitHub shows it: a heading with the verdict, why it did not pass, and a table of
/// the limits; the metrics without a limit are folded away.
[[nodiscard]] std::string to_markdown(const RunSummary& summary);

/// A scenario without a summary as Markdown: a heading and the reason.
[[nodiscard]] std::string error_markdown(const std::string& scenario, const std::string& reason);

/// Appends a text to a file. Throws std::runtime_error with file and reason.
void append_markdown(const std::filesystem::path& file, const std::string& text);

}  // namespace sextant::reports
