#include "trace_file.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "sextant/recording/trace_recorder.hpp"
#include "sextant/recording/trace_threads.hpp"

namespace sextant {
namespace {

constexpr std::chrono::seconds flush_period{1};
constexpr std::size_t rows_per_clock_reading = 8;
// A chunk is about what 1 kHz fills between two flushes: a chunk flushed half full is written again later.
constexpr std::size_t chunk_rows = 1024;
constexpr std::size_t buffer_rows = 8 * chunk_rows;

constexpr const char* decimation =
    "Each row is one interval: from the t_ns of the row before, which is not part of it, to its own t_ns, "
    "which is. *_min* and *_max* are the extremes over the interval (min/max envelope), *_mean* is the mean "
    "over it, all else, commands and states too, is the value at its end. So a row has nothing of after its "
    "t_ns. Times of the run are t_ns less begin_ns.";

/// With a checksum (Fletcher-32) of each chunk as it is stored, which every reader of HDF5 verifies.
hdf5::Handle chunked_and_compressed(int level) {
  hdf5::Handle properties{H5Pcreate(H5P_DATASET_CREATE), H5Pclose};
  const hsize_t chunk = chunk_rows;
  hdf5::check(H5Pset_chunk(properties.get(), 1, &chunk));
  if (level > 0) {
    hdf5::check(H5Pset_shuffle(properties.get()));
    hdf5::check(H5Pset_deflate(properties.get(), static_cast<unsigned>(level)));
  }
  hdf5::check(H5Pset_fletcher32(properties.get()));
  return properties;
}

/// The time belongs to every trace.
bool is_chosen(const TraceColumn& column, const std::vector<std::string>& signals) {
  if (&column == trace_columns.data()) return true;
  return std::any_of(signals.begin(), signals.end(), [&column](const std::string& name) {
    return name == "all" || name == column.group || name == column.path();
  });
}

/// A group of the file, made where there is none; the root has no name.
hdf5::Handle open_folder(hid_t file, const char* name) {
  if (*name == '\0') return {H5Gopen2(file, "/", H5P_DEFAULT), H5Gclose};
  if (H5Lexists(file, name, H5P_DEFAULT) > 0) return {H5Gopen2(file, name, H5P_DEFAULT), H5Gclose};
  return {H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose};
}

}  // namespace

bool may_write_traces_from_threads() noexcept {
  hbool_t is_safe = false;
  return H5is_library_threadsafe(&is_safe) >= 0 && is_safe;
}

bool is_trace(const std::filesystem::path& file) {
  const hdf5::Quiet quiet;
  if (!std::filesystem::is_regular_file(file)) return false;
  const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (id < 0) return false;
  const hdf5::Handle opened{id, H5Fclose};
  return H5Aexists(opened.get(), "sextant_version") > 0;
}

TraceFile::TraceFile(const std::filesystem::path& file, const Parameters& parameters,
                     std::function<void(const std::string&)> on_error)
    : name_{file.string()}, on_error_{std::move(on_error)} {
  const hdf5::Quiet quiet;
  file_ = hdf5::GrowingFile{name_};
  write_attributes(parameters);
  create_columns(parameters);
  file_.flush();
}

void TraceFile::write_attributes(const Parameters& parameters) {
  const bool sampled = parameters.control_period_ns.has_value();
  hdf5::write_attribute(file_.get(), "scenario", parameters.scenario);
  hdf5::write_attribute(file_.get(), "sextant_version", SEXTANT_VERSION);
  hdf5::write_attribute(file_.get(), "mode", sampled ? "sampled" : "event_exact");
  if (sampled) hdf5::write_attribute(file_.get(), "control_period_ns", *parameters.control_period_ns);
  hdf5::write_attribute(file_.get(), "interval_ns", parameters.interval_ns);
  if (parameters.begin_ns) hdf5::write_attribute(file_.get(), "begin_ns", *parameters.begin_ns);
  hdf5::write_attribute(file_.get(), "decimation", decimation);
}

void TraceFile::create_columns(const Parameters& parameters) {
  const hdf5::Handle properties = chunked_and_compressed(parameters.compression);
  channel_columns_ = channel_columns(parameters.channels);
  columns_.reserve(trace_columns.size() + channel_columns_.size());
  const auto create = [&](const TraceColumn& c) {
    if (!is_chosen(c, parameters.signals)) return;
    const hdf5::Handle folder = open_folder(file_.get(), c.folder);
    columns_.emplace_back(folder.get(), c, properties.get(), buffer_rows);
  };
  for (const TraceColumn& c : trace_columns) {
    if (parameters.plant || *c.folder == '\0') create(c);
  }
  for (const TraceColumn& c : channel_columns_) create(c);
}

void TraceFile::append(const TraceRow& row) {
  if (!file_) return;
  for (TraceColumnWriter& c : columns_) c.push(row);
  ++waiting_;
  if (flush_is_due()) flush();
}

bool TraceFile::flush_is_due() const {
  const std::size_t rows = waiting_ + written_ % chunk_rows;
  if (rows >= buffer_rows) return true;
  return rows % rows_per_clock_reading == 0 && Clock::now() - last_flush_ >= flush_period;
}

void TraceFile::flush() {
  if (!file_ || waiting_ == 0) return;
  guarded([this] {
    file_.write(most_bytes(), [this] {
      for (TraceColumnWriter& c : columns_) c.write(written_);
    });
  });
  written_ += std::exchange(waiting_, 0);
  last_flush_ = Clock::now();
}

void TraceFile::close() {
  flush();
  if (!file_) return;
  guarded([this] {
    for (TraceColumnWriter& c : columns_) c.close();
    columns_.clear();
    file_.close();
  });
}

// Every chunk that the rows touch, uncompressed, and its index.
std::size_t TraceFile::most_bytes() const noexcept {
  constexpr std::size_t value_bytes = 8;
  constexpr std::size_t index_bytes = 16'384;
  return columns_.size() * ((waiting_ + 2 * chunk_rows) * value_bytes + index_bytes);
}

// Runs something that writes. The first failure ends the recording: a trace with a hole would mislead.
template <class Write>
void TraceFile::guarded(Write&& write) {
  const hdf5::Quiet quiet;
  try {
    write();
  } catch (const std::runtime_error& e) {
    error_ = fmt::format("{}: recording stopped, cannot write the trace: {}", name_, e.what());
    abandon();
    on_error_(error_);
  }
}

void TraceFile::abandon() noexcept {
  for (TraceColumnWriter& c : columns_) c.abandon();
  columns_.clear();
  file_.abandon();
}

}  // namespace sextant
