#include "trace_file.hpp"

#include <algorithm>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "sextant/sim/trace_recorder.hpp"

namespace sextant {
namespace {

constexpr std::chrono::seconds flush_period{1};
constexpr std::size_t rows_per_clock_reading = 8;
// A chunk is about what 1 kHz fills between two flushes: a chunk flushed half full is written again later.
constexpr std::size_t chunk_rows = 1024;
constexpr std::size_t buffer_rows = 8 * chunk_rows;

constexpr const char* decimation =
    "Each row is one interval, its time that of the interval's end. *_min* and *_max* are the extremes over "
    "the interval (min/max envelope), *_mean* is the mean over it, all else is the value at its end.";

hdf5::Handle chunked_and_compressed(int level) {
  hdf5::Handle properties{H5Pcreate(H5P_DATASET_CREATE), H5Pclose};
  const hsize_t chunk = chunk_rows;
  hdf5::check(H5Pset_chunk(properties.get(), 1, &chunk));
  if (level > 0) {
    hdf5::check(H5Pset_shuffle(properties.get()));
    hdf5::check(H5Pset_deflate(properties.get(), static_cast<unsigned>(level)));
  }
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

/// Freed space in the file is not used again, so that the data of a flush stays readable during the next
/// flush, and after one that was interrupted.
hdf5::Handle append_only() {
  hdf5::Handle properties{H5Pcreate(H5P_FILE_CREATE), H5Pclose};
  hdf5::check(H5Pset_file_space_strategy(properties.get(), H5F_FSPACE_STRATEGY_NONE, false, 1));
  return properties;
}

}  // namespace

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
  // HDF5's own clean-up at exit crashes on a file that could not be written to its end; `close` needs none.
  H5dont_atexit();
  const hdf5::Quiet quiet;
  file_ = {H5Fcreate(name_.c_str(), H5F_ACC_TRUNC, append_only().get(), H5P_DEFAULT), H5Fclose};
  write_attributes(parameters);
  create_columns(parameters);
  hdf5::check(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL));
}

void TraceFile::write_attributes(const Parameters& parameters) {
  const bool sampled = parameters.control_period_ns.has_value();
  hdf5::write_attribute(file_.get(), "scenario", parameters.scenario);
  hdf5::write_attribute(file_.get(), "sextant_version", SEXTANT_VERSION);
  hdf5::write_attribute(file_.get(), "mode", sampled ? "sampled" : "event_exact");
  if (sampled) hdf5::write_attribute(file_.get(), "control_period_ns", *parameters.control_period_ns);
  hdf5::write_attribute(file_.get(), "interval_ns", parameters.interval_ns);
  hdf5::write_attribute(file_.get(), "decimation", decimation);
}

void TraceFile::create_columns(const Parameters& parameters) {
  const hdf5::Handle properties = chunked_and_compressed(parameters.compression);
  columns_.reserve(trace_columns.size());
  for (const TraceColumn& c : trace_columns) {
    const bool known = parameters.plant || *c.folder == '\0';
    if (!known || !is_chosen(c, parameters.signals)) continue;
    const hdf5::Handle folder = open_folder(file_.get(), c.folder);
    columns_.emplace_back(folder.get(), c, properties.get(), buffer_rows);
  }
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
    reserve_space();
    for (TraceColumnWriter& c : columns_) c.write(written_);
    // Nothing of a row reaches the file before this call, so that a kill between two flushes finds it whole.
    hdf5::check(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL));
    trim_space();
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

int TraceFile::descriptor() const {
  void* descriptor = nullptr;
  hdf5::check(H5Fget_vfd_handle(file_.get(), H5P_DEFAULT, &descriptor));
  return *static_cast<int*>(descriptor);
}

off_t TraceFile::size() const {
  hsize_t bytes = 0;
  hdf5::check(H5Fget_filesize(file_.get(), &bytes));
  return static_cast<off_t>(bytes);
}

// HDF5 writes its index even where the data before it found no room, which loses the whole file. So the room
// is taken first, for more than the rows can need: every chunk they touch, uncompressed, and its index.
void TraceFile::reserve_space() {
  constexpr std::size_t value_bytes = 8;
  constexpr std::size_t index_bytes = 16'384;
  const std::size_t values = waiting_ + 2 * chunk_rows;
  const std::size_t bytes = columns_.size() * (values * value_bytes + index_bytes);
  if (const int error = ::posix_fallocate(descriptor(), size(), static_cast<off_t>(bytes))) {
    throw std::runtime_error{std::generic_category().message(error)};
  }
}

// Room that stays behind does no harm, so that failing here ends nothing.
void TraceFile::trim_space() {
  if (::ftruncate(descriptor(), size()) != 0) return;
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

// Closing would write again, over what the last flush left whole: HDF5 offers no other way than to let go.
void TraceFile::abandon() noexcept {
  for (TraceColumnWriter& c : columns_) c.abandon();
  columns_.clear();
  file_.release();
}

}  // namespace sextant
