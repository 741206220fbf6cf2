#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <vector>

namespace sextant {

/// A CSV file of numbers: a heading with the names of its columns, one row a line, separated by commas; a
/// cell may stand in quotes. Empty lines and what follows a # are passed over.
struct CsvTable {
  std::string file{};  ///< as messages show it
  int heading_line{};  ///< from 1 [-]
  std::vector<std::string> columns{};
  std::vector<int> lines{};                 ///< of the rows, from 1 [-]
  std::vector<std::vector<double>> rows{};  ///< finite, one number for each column

  /// Index of a column. Throws std::runtime_error when there is none of that name.
  [[nodiscard]] std::size_t column(const std::string& name) const;

  /// Throws std::runtime_error where there is a column of another name.
  void expect_only(std::initializer_list<const char*> names) const;

  /// "file:line" of a row, for messages.
  [[nodiscard]] std::string place(std::size_t row) const;
};

/// Reads a file with at least one row. Throws std::runtime_error with one sentence that names file, line and
/// column, also beyond the bounds of TextLines.
[[nodiscard]] CsvTable read_csv(const std::string& file);

}  // namespace sextant
