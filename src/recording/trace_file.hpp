#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "growing_file.hpp"
#include "trace_column_writer.hpp"

namespace sextant {

/// The HDF5 file of a trace, which takes rows and is whole in itself after each flush.
class TraceFile {
 public:
  struct Parameters {
    std::string scenario{};                           ///< name of the scenario
    std::optional<std::int64_t> control_period_ns{};  ///< none in an event-exact run [ns]
    std::int64_t interval_ns{};                       ///< [ns]
    std::optional<std::int64_t> begin_ns{};           ///< of the run, on the clock of its rows [ns]
    int compression{};                                ///< deflate level [-]
    bool plant{true};                                 ///< the plant's true values are known
    std::span<const ControlChannel> channels{};       ///< of the controller
    std::vector<std::string> signals{};               ///< names of signals and of groups
  };

  /// Throws std::runtime_error with the reason if the file cannot be created.
  TraceFile(const std::filesystem::path& file, const Parameters& parameters,
            std::function<void(const std::string&)> on_error);
  ~TraceFile() { close(); }
  TraceFile(const TraceFile&) = delete;
  TraceFile& operator=(const TraceFile&) = delete;

  /// Adds a row, and writes those that wait when there are many or about once a second.
  void append(const TraceRow& row);
  void flush();
  void close();

  /// False once it is closed or abandoned.
  [[nodiscard]] bool is_open() const noexcept { return bool(file_); }
  [[nodiscard]] const std::string& error() const noexcept { return error_; }

 private:
  using Clock = std::chrono::steady_clock;

  void write_attributes(const Parameters& parameters);
  void create_columns(const Parameters& parameters);
  [[nodiscard]] bool flush_is_due() const;
  [[nodiscard]] std::size_t most_bytes() const noexcept;
  template <class Write>
  void guarded(Write&& write);
  void abandon() noexcept;

  std::string name_;
  std::function<void(const std::string&)> on_error_;
  hdf5::GrowingFile file_{};
  std::vector<TraceColumn> channel_columns_{};  // which some of the writers refer to
  std::vector<TraceColumnWriter> columns_{};
  std::size_t waiting_{0};  // rows that are yet to be written
  hsize_t written_{0};
  Clock::time_point last_flush_{Clock::now()};
  std::string error_{};
};

}  // namespace sextant
