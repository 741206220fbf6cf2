#include "reports/result_directory.hpp"

#include <cstdio>
#include <ctime>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include <sys/stat.h>

#include "sextant/recording/trace_recorder.hpp"
#include "sextant/run/summary.hpp"

namespace sextant::reports {
namespace {

namespace fs = std::filesystem;

/// When a file was written, in UTC.
std::string written_at(const fs::path& file) {
  struct stat status{};
  if (::stat(file.c_str(), &status) != 0) return "unknown time";
  std::tm utc{};
  gmtime_r(&status.st_mtim.tv_sec, &utc);
  char text[32]{};
  (void)std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", &utc);
  return text;
}

[[noreturn]] void refuse(const fs::path& file) {
  throw std::runtime_error(
      file.string() + " is there and is no result of a run: move it, or name another directory with --out");
}

}  // namespace

ResultDirectory::ResultDirectory(fs::path directory, const std::string& program)
    : directory_{std::move(directory)} {
  std::error_code error;
  fs::create_directories(directory_, error);
  if (error) {
    throw std::runtime_error("the directory " + directory_.string() + " cannot be made: " + error.message() +
                             "; --out names another");
  }
  clear(program);
}

void ResultDirectory::clear(const std::string& program) const {
  const bool has_summary = fs::exists(summary());
  const bool has_trace = fs::exists(trace());
  if (!has_summary && !has_trace) return;
  const std::optional<std::string> scenario = has_summary ? scenario_of_summary(summary()) : std::nullopt;
  if (has_summary && !scenario) refuse(summary());
  // A run that ended before its trace had a byte leaves an empty file.
  if (has_trace && fs::file_size(trace()) > 0 && !is_trace(trace())) refuse(trace());
  std::string line = directory_.string() + ": replaces the result of ";
  line += scenario ? "\"" + *scenario + "\"" : std::string{"a run that was not finished,"};
  line += " of " + written_at(has_summary ? summary() : trace());
  std::fprintf(stderr, "%s: %s\n", program.c_str(), line.c_str());
  fs::remove(summary());
  fs::remove(trace());
}

}  // namespace sextant::reports
