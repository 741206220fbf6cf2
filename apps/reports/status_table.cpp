#include "reports/status_table.hpp"

#include <cstddef>

#include <fmt/format.h>

#include "common/exit_status.hpp"
#include "sextant/run/verdict.hpp"

namespace sextant::reports {

std::string verdict_status_table() {
  std::string table;
  for (std::size_t k = 0; k < verdict_catalogue.size(); ++k) {
    const auto verdict = static_cast<Verdict>(k);
    const VerdictInfo& row = info(verdict);
    std::string meaning = row.meaning;
    if (exit_status(verdict, true) != row.status)
      meaning += fmt::format("; {} with --require-expectations", exit_status(verdict, true));
    table += exit_status_line(row.status, row.word, meaning);
  }
  return table + refused_line();
}

}  // namespace sextant::reports
