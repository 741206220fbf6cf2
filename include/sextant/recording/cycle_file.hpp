#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sextant/drive/cycle_record.hpp"

namespace sextant {

/// Whether there is such a file.
[[nodiscard]] bool is_cycle_file(const std::string& file);

/// The file of a run's control periods: HDF5 with one dataset `cycles`, a row a control period, and the
/// configuration of the drive as text, so that the file is all that a replay needs. The file is whole in
/// itself after each 8192 rows, whatever ends the program.
class CycleFileWriter {
 public:
  /// configuration: as printed by --print-config. Throws std::runtime_error with one sentence where the file
  /// cannot be made or is there and of another kind.
  CycleFileWriter(const std::string& file, const std::string& configuration);
  CycleFileWriter(const CycleFileWriter&) = delete;
  CycleFileWriter& operator=(const CycleFileWriter&) = delete;
  ~CycleFileWriter();

  /// Throws std::runtime_error with the reason at the first failure, then does nothing; the rows `written`
  /// stay readable.
  void append(std::span<const CycleRecord<double>> records);
  /// dropped: control periods that are not in the file [-]. Throws as append.
  void close(std::uint64_t dropped);

  /// Rows that are in the file. [-]
  [[nodiscard]] std::uint64_t written() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

class CycleFileReader {
 public:
  /// Throws std::runtime_error with one sentence where the file is none of this kind.
  explicit CycleFileReader(const std::string& file);
  CycleFileReader(const CycleFileReader&) = delete;
  CycleFileReader& operator=(const CycleFileReader&) = delete;
  ~CycleFileReader();

  [[nodiscard]] const std::string& configuration() const noexcept;
  /// Version of Sextant that wrote the file.
  [[nodiscard]] const std::string& version() const noexcept;
  [[nodiscard]] std::uint64_t size() const noexcept;
  /// Control periods that the writer lost; none where the file was not closed, so that its end is missing.
  /// [-]
  [[nodiscard]] std::optional<std::uint64_t> dropped() const noexcept;

  /// At most `most` further records, none at the end.
  [[nodiscard]] std::vector<CycleRecord<double>> next(std::size_t most = 4096);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sextant
