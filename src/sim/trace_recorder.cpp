#include "sextant/sim/trace_recorder.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <span>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "hdf5_handle.hpp"
#include "sextant/core/telemetry_interval.hpp"
#include "trace_columns.hpp"

namespace sextant {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds flush_period{1};
// A chunk is about what 1 kHz fills between two flushes: a chunk flushed half full is written again later.
constexpr std::size_t chunk_rows = 1024;
constexpr std::size_t buffer_rows = 8 * chunk_rows;

hdf5::Handle drive_state_type() {
  hdf5::Handle type{H5Tenum_create(H5T_NATIVE_UINT8), H5Tclose};
  for (auto s = std::uint8_t(DriveState::init); s <= std::uint8_t(DriveState::shutdown); ++s) {
    hdf5::check(H5Tenum_insert(type.get(), to_string(DriveState{s}), &s));
  }
  return type;
}

hdf5::Handle memory_type(ColumnType type) {
  switch (type) {
    case ColumnType::float64:
      return {H5Tcopy(H5T_NATIVE_DOUBLE), H5Tclose};
    case ColumnType::int64:
      return {H5Tcopy(H5T_NATIVE_INT64), H5Tclose};
    case ColumnType::uint32:
      return {H5Tcopy(H5T_NATIVE_UINT32), H5Tclose};
    case ColumnType::uint8:
      return {H5Tcopy(H5T_NATIVE_UINT8), H5Tclose};
    case ColumnType::drive_state:
      return drive_state_type();
  }
  throw std::logic_error{"a column of unknown type"};
}

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

/// Space in the file that has been given up is not used again, so that what a flush left behind stays
/// readable while, and if only half of, the next one is written.
hdf5::Handle append_only() {
  hdf5::Handle properties{H5Pcreate(H5P_FILE_CREATE), H5Pclose};
  hdf5::check(H5Pset_file_space_strategy(properties.get(), H5F_FSPACE_STRATEGY_NONE, false, 1));
  return properties;
}

/// One dataset that grows.
class ColumnWriter {
 public:
  ColumnWriter(hid_t group, const TraceColumn& column, hid_t properties)
      : column_{&column}, type_{memory_type(column.type)} {
    const hsize_t none = 0;
    const hsize_t unlimited = H5S_UNLIMITED;
    const hdf5::Handle space{H5Screate_simple(1, &none, &unlimited), H5Sclose};
    dataset_ = {
        H5Dcreate2(group, column.name, type_.get(), space.get(), H5P_DEFAULT, properties, H5P_DEFAULT),
        H5Dclose};
    hdf5::write_attribute(dataset_.get(), "unit", column.unit);
    hdf5::write_attribute(dataset_.get(), "description", column.description);
  }

  /// Appends this column of `rows` behind the first `written` values.
  void append(std::span<const TraceRow> rows, hsize_t written, std::vector<std::byte>& scratch) {
    scratch.resize(rows.size() * column_->size);
    std::byte* to = scratch.data();
    for (const TraceRow& row : rows) {
      std::memcpy(to, reinterpret_cast<const std::byte*>(&row) + column_->offset, column_->size);
      to += column_->size;
    }
    const hsize_t count = rows.size();
    const hsize_t extent = written + count;
    hdf5::check(H5Dset_extent(dataset_.get(), &extent));
    const hdf5::Handle file_space{H5Dget_space(dataset_.get()), H5Sclose};
    hdf5::check(H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, &written, nullptr, &count, nullptr));
    const hdf5::Handle memory_space{H5Screate_simple(1, &count, nullptr), H5Sclose};
    hdf5::check(H5Dwrite(dataset_.get(), type_.get(), memory_space.get(), file_space.get(), H5P_DEFAULT,
                         scratch.data()));
  }

  void close() { dataset_.close(); }
  void abandon() noexcept { dataset_.release(); }

 private:
  const TraceColumn* column_;
  hdf5::Handle type_;
  hdf5::Handle dataset_;
};

/// Mean, minimum and maximum of the plant's torque over an interval.
struct TorqueEnvelope {
  double sum{0};
  double min{std::numeric_limits<double>::quiet_NaN()};  // fmin and fmax prefer a number to NaN
  double max{std::numeric_limits<double>::quiet_NaN()};

  void add(double torque) noexcept {
    sum += torque;
    min = std::fmin(min, torque);
    max = std::fmax(max, torque);
  }
};

PlantRow plant_row(const PlantSample& last, const TorqueEnvelope& torque, std::uint32_t periods) noexcept {
  return {.torque_nm = last.torque,
          .torque_mean_nm = torque.sum / periods,
          .torque_min_nm = torque.min,
          .torque_max_nm = torque.max,
          .psi_s_wb = magnitude(last.psi_s),
          .psi_s_alpha_wb = last.psi_s.alpha,
          .psi_s_beta_wb = last.psi_s.beta,
          .psi_r_alpha_wb = last.psi_r.alpha,
          .psi_r_beta_wb = last.psi_r.beta,
          .i_a_a = last.i_abc.a,
          .i_b_a = last.i_abc.b,
          .i_c_a = last.i_abc.c,
          .u_dc_v = last.u_dc,
          .omega_m_rad_s = last.omega_m,
          .tau_l_nm = last.tau_l};
}

std::uint32_t whole_periods(const TraceParameters& parameters, std::int64_t control_period_ns) {
  if (const char* wrong = parameters.validate()) throw std::runtime_error{wrong};
  if (control_period_ns <= 0) throw std::runtime_error{"the control period must be above zero"};
  const std::int64_t interval_ns = std::llround(parameters.interval_us * 1e3);
  const std::int64_t periods = interval_ns / control_period_ns;
  if (periods < 1 || periods * control_period_ns != interval_ns ||
      periods > std::numeric_limits<std::uint32_t>::max()) {
    throw std::runtime_error{
        fmt::format("the trace interval of {} us is not a whole number of control periods of {} us",
                    parameters.interval_us, double(control_period_ns) * 1e-3)};
  }
  return static_cast<std::uint32_t>(periods);
}

}  // namespace

class TraceRecorder::Impl {
 public:
  Impl(const std::filesystem::path& file, const TraceParameters& parameters, const TraceOrigin& origin,
       ErrorHandler on_error)
      : name_{file.string()},
        on_error_{on_error ? std::move(on_error) : print_error},
        periods_per_row_{whole_periods(parameters, origin.control_period_ns)} {
    // HDF5's own clean-up at exit crashes on a file that could not be written to its end; `close` needs none.
    H5dont_atexit();
    const hdf5::Quiet quiet;
    file_ = {H5Fcreate(name_.c_str(), H5F_ACC_TRUNC, append_only().get(), H5P_DEFAULT), H5Fclose};
    hdf5::write_attribute(file_.get(), "scenario", origin.scenario);
    hdf5::write_attribute(file_.get(), "sextant_version", SEXTANT_VERSION);
    hdf5::write_attribute(file_.get(), "control_period_ns", origin.control_period_ns);
    hdf5::write_attribute(file_.get(), "interval_ns", origin.control_period_ns * periods_per_row_);
    const hdf5::Handle properties = chunked_and_compressed(parameters.compression);
    const hdf5::Handle plant{H5Gcreate2(file_.get(), "plant", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                             H5Gclose};
    columns_.reserve(drive_columns.size() + plant_columns.size());
    for (const TraceColumn& c : drive_columns) columns_.emplace_back(file_.get(), c, properties.get());
    for (const TraceColumn& c : plant_columns) columns_.emplace_back(plant.get(), c, properties.get());
    hdf5::check(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL));
    rows_.reserve(buffer_rows);
  }

  ~Impl() { close(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void add(const Telemetry<>& telemetry, const PlantSample& plant) {
    if (!file_) return;
    interval_.add(telemetry);
    torque_.add(plant.torque);
    last_plant_ = plant;
    if (interval_.count() < periods_per_row_) return;
    finish_row();
    const bool buffer_full = rows_.size() + written_ % chunk_rows >= buffer_rows;
    if (buffer_full || Clock::now() - last_flush_ >= flush_period) flush();
  }

  void flush() {
    if (!file_ || rows_.empty()) return;
    guarded([this] {
      reserve_space();
      for (ColumnWriter& c : columns_) c.append(rows_, written_, scratch_);
      // Nothing of a row reaches the file before this call, so that a kill between two flushes finds it
      // whole.
      hdf5::check(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL));
      trim_space();
    });
    written_ += rows_.size();
    rows_.clear();
    last_flush_ = Clock::now();
  }

  void close() {
    if (!file_) return;
    if (interval_.count() > 0) finish_row();
    flush();
    if (!file_) return;
    guarded([this] {
      for (ColumnWriter& c : columns_) c.close();
      columns_.clear();
      file_.close();
    });
  }

  [[nodiscard]] const std::string& error() const noexcept { return error_; }

 private:
  static void print_error(const std::string& error) { std::fprintf(stderr, "%s\n", error.c_str()); }

  void finish_row() {
    const auto drive = interval_.record();
    rows_.push_back({.drive = drive, .plant = plant_row(last_plant_, torque_, drive.periods)});
    interval_.reset();
    torque_ = {};
  }

  [[nodiscard]] int descriptor() const {
    void* descriptor = nullptr;
    hdf5::check(H5Fget_vfd_handle(file_.get(), H5P_DEFAULT, &descriptor));
    return *static_cast<int*>(descriptor);
  }

  [[nodiscard]] off_t size() const {
    hsize_t bytes = 0;
    hdf5::check(H5Fget_filesize(file_.get(), &bytes));
    return static_cast<off_t>(bytes);
  }

  // HDF5 writes its index even where the data before it found no room, which loses the whole file. So the
  // room is taken first, for more than the rows can need: every chunk they touch, uncompressed, and its
  // index.
  void reserve_space() {
    constexpr std::size_t value_bytes = 8;
    constexpr std::size_t index_bytes = 16'384;
    const std::size_t values = rows_.size() + 2 * chunk_rows;
    const std::size_t bytes = columns_.size() * (values * value_bytes + index_bytes);
    if (const int error = ::posix_fallocate(descriptor(), size(), static_cast<off_t>(bytes))) {
      throw std::runtime_error{std::generic_category().message(error)};
    }
  }

  // Room that stays behind does no harm, so that failing here ends nothing.
  void trim_space() {
    if (::ftruncate(descriptor(), size()) != 0) return;
  }

  // Runs something that writes. The first failure ends the recording: a trace with a hole would mislead.
  template <class Write>
  void guarded(Write&& write) {
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
  void abandon() noexcept {
    for (ColumnWriter& c : columns_) c.abandon();
    columns_.clear();
    file_.release();
  }

  std::string name_;
  ErrorHandler on_error_;
  std::uint32_t periods_per_row_;
  hdf5::Handle file_;
  std::vector<ColumnWriter> columns_{};
  TelemetryInterval<> interval_{};
  TorqueEnvelope torque_{};
  PlantSample last_plant_{};
  std::vector<TraceRow> rows_{};
  std::vector<std::byte> scratch_{};
  hsize_t written_{0};
  Clock::time_point last_flush_{Clock::now()};
  std::string error_{};
};

TraceRecorder::TraceRecorder(const std::filesystem::path& file, const TraceParameters& parameters,
                             const TraceOrigin& origin, ErrorHandler on_error) {
  try {
    impl_ = std::make_unique<Impl>(file, parameters, origin, std::move(on_error));
  } catch (const std::runtime_error& e) {
    throw std::runtime_error{fmt::format("{}: cannot record a trace: {}", file.string(), e.what())};
  }
}

TraceRecorder::~TraceRecorder() = default;
TraceRecorder::TraceRecorder(TraceRecorder&&) noexcept = default;
TraceRecorder& TraceRecorder::operator=(TraceRecorder&&) noexcept = default;

void TraceRecorder::add(const Telemetry<>& telemetry, const PlantSample& plant) {
  impl_->add(telemetry, plant);
}
void TraceRecorder::flush() {
  impl_->flush();
}
void TraceRecorder::close() {
  impl_->close();
}
const std::string& TraceRecorder::error() const noexcept {
  return impl_->error();
}

}  // namespace sextant
