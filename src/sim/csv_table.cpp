#include "sextant/sim/csv_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sextant/files/text_lines.hpp"

namespace sextant {
namespace {

template <class... Args>
[[noreturn]] void refuse(fmt::format_string<Args...> text, Args&&... args) {
  throw std::runtime_error{fmt::format(text, std::forward<Args>(args)...)};
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blank = " \t\r";
  const std::size_t begin = text.find_first_not_of(blank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(blank) - begin + 1);
}

/// The cells of a line; none where there is nothing but blanks and a comment.
std::vector<std::string> cells_of(std::string_view line) {
  line = trimmed(line.substr(0, line.find('#')));
  std::vector<std::string> cells;
  if (line.empty()) return cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells.emplace_back(trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return cells;
}

/// NaN for anything that is not a finite number.
double number(const std::string& cell) {
  double x{};
  const char* const end = cell.data() + cell.size();
  const auto result = std::from_chars(cell.data(), end, x);
  const bool whole = result.ec == std::errc{} && result.ptr == end;
  return whole && std::isfinite(x) ? x : std::nan("");
}

void add_row(CsvTable& table, int line, const std::vector<std::string>& cells) {
  if (cells.size() != table.columns.size()) {
    refuse("{}:{}: expected {} values ({}), found {}", table.file, line, table.columns.size(),
           fmt::join(table.columns, ","), cells.size());
  }
  std::vector<double> row;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    row.push_back(number(cells[k]));
    if (std::isnan(row.back())) {
      refuse("{}:{}: {} must be a finite number, not \"{}\"", table.file, line, table.columns[k], cells[k]);
    }
  }
  table.rows.push_back(std::move(row));
  table.lines.push_back(line);
}

void set_heading(CsvTable& table, int line, std::vector<std::string> cells) {
  table.heading_line = line;
  table.columns = std::move(cells);
  for (auto name = table.columns.begin(); name != table.columns.end(); ++name) {
    if (!std::isnan(number(*name)) || name->empty())
      refuse("{}:{}: expected a heading with the names of the columns, found \"{}\"", table.file, line,
             fmt::join(table.columns, ","));
    if (std::find(table.columns.begin(), name, *name) != name)
      refuse("{}:{}: the column {} occurs twice", table.file, line, *name);
  }
}

}  // namespace

std::size_t CsvTable::column(const std::string& name) const {
  const auto found = std::find(columns.begin(), columns.end(), name);
  if (found == columns.end())
    refuse("{}:{}: expected a column {}, found {}", file, heading_line, name, fmt::join(columns, ","));
  return static_cast<std::size_t>(found - columns.begin());
}

std::string CsvTable::place(std::size_t row) const {
  return fmt::format("{}:{}", file, lines[row]);
}

CsvTable read_csv(const std::string& file) {
  TextLines lines{file};
  CsvTable table;
  table.file = file;
  for (std::string text; lines.next(text);) {
    std::vector<std::string> cells = cells_of(text);
    if (cells.empty()) continue;
    if (table.columns.empty()) {
      set_heading(table, lines.number(), std::move(cells));
    } else {
      add_row(table, lines.number(), cells);
    }
  }
  if (table.rows.empty()) refuse("{} is empty: expected a heading and at least one row", file);
  return table;
}

}  // namespace sextant
