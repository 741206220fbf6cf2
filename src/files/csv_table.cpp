#include "sextant/files/csv_table.hpp"

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

/// What no text has; lines have no ends here.
bool is_control(char byte) {
  return (byte >= 0 && byte < ' ' && byte != '\t') || byte == 0x7f;
}

void refuse_control(const TextLines& lines, const std::string& line) {
  const auto found = std::ranges::find_if(line, is_control);
  if (found == line.end()) return;
  lines.refuse(fmt::format(
      "the byte 0x{:02x} is no text; save the file as text in UTF-8, or remove that byte", *found));
}

/// A cell without the quotes that it stands in; "" in these is one quote.
std::string unquoted(std::string_view cell) {
  cell = trimmed(cell);
  if (cell.size() < 2 || cell.front() != '"' || cell.back() != '"') return std::string{cell};
  std::string text;
  for (std::size_t k = 1; k + 1 < cell.size(); ++k) {
    text.push_back(cell[k]);
    if (cell[k] == '"' && cell[k + 1] == '"' && k + 2 < cell.size()) ++k;
  }
  return text;
}

/// The cells of a line; none where there is nothing but blanks and a comment. Commas and # within quotes are
/// part of a cell.
std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells;
  bool is_quoted = false;
  std::size_t begin = 0;
  std::size_t end = 0;
  for (; end < line.size() && (is_quoted || line[end] != '#'); ++end) {
    if (line[end] == '"') is_quoted = !is_quoted;
    if (is_quoted || line[end] != ',') continue;
    cells.push_back(unquoted(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  const std::string_view last = line.substr(begin, end - begin);
  if (!cells.empty() || !trimmed(last).empty()) cells.push_back(unquoted(last));
  return cells;
}

/// NaN for anything that is not a finite number.
double number(const std::string& cell) {
  double x{};
  const char* const end = cell.data() + cell.size();
  const bool has_plus =
      cell.size() > 1 && cell[0] == '+' && cell[1] != '-';  // which from_chars does not read
  const auto result = std::from_chars(cell.data() + (has_plus ? 1 : 0), end, x);
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

/// Refuses a heading of one cell in which another separator than the comma stands.
void refuse_separator(const CsvTable& table, char separator, const char* name) {
  if (table.columns.size() != 1 || table.columns.front().find(separator) == std::string::npos) return;
  refuse("{}:{}: {} separate the columns: separate them by commas, and write numbers with points", table.file,
         table.heading_line, name);
}

void set_heading(CsvTable& table, int line, std::vector<std::string> cells) {
  table.heading_line = line;
  table.columns = std::move(cells);
  refuse_separator(table, ';', "semicolons");
  refuse_separator(table, '\t', "tabs");
  if (table.columns.size() > 1 && table.columns.front().empty()) {
    refuse("{}:{}: the first column has no name: name it or leave it out (of pandas: to_csv(index=False))",
           table.file, line);
  }
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

void CsvTable::expect_only(std::initializer_list<const char*> names) const {
  for (const std::string& column : columns) {
    if (std::find(names.begin(), names.end(), column) != names.end()) continue;
    refuse("{}:{}: unknown column {}; known are {}", file, heading_line, column, fmt::join(names, ","));
  }
}

std::string CsvTable::place(std::size_t row) const {
  return fmt::format("{}:{}", file, lines[row]);
}

CsvTable read_csv(const std::string& file) {
  TextLines lines{file};
  CsvTable table;
  table.file = file;
  for (std::string text; lines.next(text);) {
    refuse_control(lines, text);
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
