#include "sextant/recording/cycle_file.hpp"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <stdexcept>
#include <utility>

#include <hdf5.h>

#include "cycle_row.hpp"
#include "growing_file.hpp"

namespace sextant {
namespace {

constexpr const char* dataset_name = "cycles";
constexpr const char* configuration_name = "configuration";
constexpr const char* version_name = "sextant_version";
constexpr const char* dropped_name = "dropped";
constexpr hsize_t rows_per_chunk = 1024;
constexpr hsize_t rows_per_write = 8 * rows_per_chunk;
constexpr unsigned deflate_level = 1;

/// Text of any length: an attribute holds 64 KiB at most.
void write_text(hid_t file, const char* name, const std::string& text) {
  const hdf5::Handle type{H5Tcopy(H5T_C_S1), H5Tclose};
  hdf5::check(H5Tset_size(type.get(), text.size() + 1));
  hdf5::check(H5Tset_cset(type.get(), H5T_CSET_UTF8));
  const hdf5::Handle space{H5Screate(H5S_SCALAR), H5Sclose};
  const hdf5::Handle dataset{
      H5Dcreate2(file, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose};
  hdf5::check(H5Dwrite(dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str()));
}

/// One text of fixed length, that `read` puts into memory of that type.
template <class Read>
std::string text_of(const hdf5::Handle& type, const hdf5::Handle& space, Read&& read) {
  const bool is_fixed = H5Tget_class(type.get()) == H5T_STRING && H5Tis_variable_str(type.get()) == 0;
  if (!is_fixed || H5Sget_simple_extent_npoints(space.get()) != 1) {
    throw std::runtime_error{"configuration or version is no text"};
  }
  std::string text(H5Tget_size(type.get()), '\0');
  hdf5::check(read(type.get(), text.data()));
  text.resize(std::min(text.find('\0'), text.size()));
  return text;
}

std::string read_text(hid_t file, const char* name) {
  const hdf5::Handle dataset{H5Dopen2(file, name, H5P_DEFAULT), H5Dclose};
  const hdf5::Handle type{H5Dget_type(dataset.get()), H5Tclose};
  const hdf5::Handle space{H5Dget_space(dataset.get()), H5Sclose};
  return text_of(type, space, [&](hid_t memory, char* text) {
    return H5Dread(dataset.get(), memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, text);
  });
}

std::string version_of(hid_t file) {
  const hdf5::Handle attribute{H5Aopen(file, version_name, H5P_DEFAULT), H5Aclose};
  const hdf5::Handle type{H5Aget_type(attribute.get()), H5Tclose};
  const hdf5::Handle space{H5Aget_space(attribute.get()), H5Sclose};
  return text_of(type, space,
                 [&](hid_t memory, char* text) { return H5Aread(attribute.get(), memory, text); });
}

/// A file that was not closed has none.
std::optional<std::uint64_t> dropped_of(hid_t file) {
  if (H5Aexists(file, dropped_name) <= 0) return {};
  const hdf5::Handle attribute{H5Aopen(file, dropped_name, H5P_DEFAULT), H5Aclose};
  const hdf5::Handle space{H5Aget_space(attribute.get()), H5Sclose};
  if (H5Sget_simple_extent_npoints(space.get()) != 1) throw std::runtime_error{"its losses are no number"};
  long long dropped = 0;
  hdf5::check(H5Aread(attribute.get(), H5T_NATIVE_LLONG, &dropped));
  return static_cast<std::uint64_t>(dropped);
}

/// Opens the rows of a file. Throws std::runtime_error where they are others than cycle_row_type().
hdf5::Handle open_rows(hid_t file, hid_t row_type) {
  hdf5::Handle dataset{H5Dopen2(file, dataset_name, H5P_DEFAULT), H5Dclose};
  const hdf5::Handle stored{H5Dget_type(dataset.get()), H5Tclose};
  const hdf5::Handle space{H5Dget_space(dataset.get()), H5Sclose};
  if (H5Tequal(stored.get(), row_type) <= 0 || H5Sget_simple_extent_ndims(space.get()) != 1) {
    throw std::runtime_error{"its rows are of another version of Sextant"};
  }
  return dataset;
}

hsize_t rows_in(const hdf5::Handle& dataset) {
  const hdf5::Handle space{H5Dget_space(dataset.get()), H5Sclose};
  hsize_t rows = 0;
  hdf5::check(H5Sget_simple_extent_dims(space.get(), &rows, nullptr));
  return rows;
}

hdf5::Handle growing_dataset(hid_t file, hid_t type) {
  const hdf5::Handle properties{H5Pcreate(H5P_DATASET_CREATE), H5Pclose};
  const hsize_t chunk = rows_per_chunk;
  hdf5::check(H5Pset_chunk(properties.get(), 1, &chunk));
  hdf5::check(H5Pset_shuffle(properties.get()));
  hdf5::check(H5Pset_deflate(properties.get(), deflate_level));
  const hsize_t none = 0;
  const hsize_t unlimited = H5S_UNLIMITED;
  const hdf5::Handle space{H5Screate_simple(1, &none, &unlimited), H5Sclose};
  return {H5Dcreate2(file, dataset_name, type, space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
          H5Dclose};
}

/// The stretch of a dataset's rows from `begin` on.
hdf5::Handle stretch(hid_t dataset, hsize_t begin, hsize_t count) {
  hdf5::Handle space{H5Dget_space(dataset), H5Sclose};
  hdf5::check(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, &begin, nullptr, &count, nullptr));
  return space;
}

/// Adds the file's name to HDF5's reason.
template <class Work>
void for_file(const std::string& file, const char* what, Work&& work) {
  const hdf5::Quiet quiet;
  try {
    work();
  } catch (const std::runtime_error& problem) {
    throw std::runtime_error{file + " " + what + ": " + problem.what()};
  }
}

}  // namespace

struct CycleFileWriter::Impl {
  std::string name{};
  hdf5::GrowingFile file{};
  hdf5::Handle type{};
  hdf5::Handle dataset{};
  std::vector<CycleRow> waiting{};
  hsize_t written{0};

  Impl(const std::string& path, const std::string& configuration) : name{path} {
    for_file(name, "cannot be written", [&] {
      file = hdf5::GrowingFile{name};
      hdf5::write_attribute(file.get(), version_name, SEXTANT_VERSION);
      write_text(file.get(), configuration_name, configuration);
      type = cycle_row_type();
      dataset = growing_dataset(file.get(), type.get());
      file.flush();
    });
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() { abandon(); }

  /// Every chunk that the rows touch, uncompressed, and its index.
  [[nodiscard]] std::size_t most_bytes() const noexcept {
    constexpr std::size_t index_bytes = 16'384;
    return (waiting.size() + 2 * rows_per_chunk) * sizeof(CycleRow) + index_bytes;
  }

  void put(hsize_t count) {
    const hsize_t extent = written + count;
    hdf5::check(H5Dset_extent(dataset.get(), &extent));
    const hdf5::Handle memory{H5Screate_simple(1, &count, nullptr), H5Sclose};
    hdf5::check(H5Dwrite(dataset.get(), type.get(), memory.get(),
                         stretch(dataset.get(), written, count).get(), H5P_DEFAULT, waiting.data()));
  }

  void abandon() noexcept {
    dataset.release();
    file.abandon();
  }

  /// Runs something that writes. The first failure ends the recording.
  template <class Write>
  void guarded(Write&& write) {
    try {
      for_file(name, "cannot be written", std::forward<Write>(write));
    } catch (const std::runtime_error&) {
      abandon();
      throw;
    }
  }

  /// The first rows that wait. Whole chunks until the end: one that is written again is lost where the
  /// program is killed meanwhile.
  void flush(hsize_t count) {
    if (count == 0) return;
    guarded([&] { file.write(most_bytes(), [&] { put(count); }); });
    written += count;
    waiting.erase(waiting.begin(), waiting.begin() + std::ptrdiff_t(count));
  }
};

CycleFileWriter::CycleFileWriter(const std::string& file, const std::string& configuration) {
  if (std::filesystem::exists(file) && !is_cycle_file(file)) {
    throw std::runtime_error{file +
                             " is there and no recording of control periods: remove it or name another file"};
  }
  impl_ = std::make_unique<Impl>(file, configuration);
}

CycleFileWriter::~CycleFileWriter() = default;

void CycleFileWriter::append(std::span<const CycleRecord<double>> records) {
  if (!impl_->file) return;
  std::ranges::transform(records, std::back_inserter(impl_->waiting), to_row);
  const hsize_t waiting = impl_->waiting.size();
  if (waiting >= rows_per_write) impl_->flush(waiting - waiting % rows_per_chunk);
}

void CycleFileWriter::close(std::uint64_t dropped) {
  if (!impl_->file) return;
  impl_->flush(impl_->waiting.size());
  impl_->guarded([&] {
    hdf5::write_attribute(impl_->file.get(), dropped_name, static_cast<long long>(dropped));
    impl_->dataset.close();
    impl_->file.close();
  });
}

std::uint64_t CycleFileWriter::written() const noexcept {
  return impl_->written;
}

struct CycleFileReader::Impl {
  hdf5::Handle file{};
  hdf5::Handle type{};
  hdf5::Handle dataset{};
  std::string configuration{};
  std::string version{};
  std::string name{};
  hsize_t size{0};
  hsize_t at{0};
  std::optional<std::uint64_t> dropped{};
};

CycleFileReader::CycleFileReader(const std::string& file) : impl_{std::make_unique<Impl>()} {
  impl_->name = file;
  for_file(file, "is no recording of control periods (sextant-ecu --record-cycles)", [&] {
    impl_->file = {H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
    impl_->type = cycle_row_type();
    impl_->dataset = open_rows(impl_->file.get(), impl_->type.get());
    impl_->configuration = read_text(impl_->file.get(), configuration_name);
    impl_->version = version_of(impl_->file.get());
    impl_->dropped = dropped_of(impl_->file.get());
    impl_->size = rows_in(impl_->dataset);
  });
}

bool is_cycle_file(const std::string& file) {
  const hdf5::Quiet quiet;
  if (!std::filesystem::is_regular_file(file)) return false;
  const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (id < 0) return false;
  const hdf5::Handle opened{id, H5Fclose};
  return H5Lexists(id, dataset_name, H5P_DEFAULT) > 0 && H5Lexists(id, configuration_name, H5P_DEFAULT) > 0;
}

CycleFileReader::~CycleFileReader() = default;

const std::string& CycleFileReader::configuration() const noexcept {
  return impl_->configuration;
}

const std::string& CycleFileReader::version() const noexcept {
  return impl_->version;
}

std::uint64_t CycleFileReader::size() const noexcept {
  return impl_->size;
}

std::optional<std::uint64_t> CycleFileReader::dropped() const noexcept {
  return impl_->dropped;
}

std::vector<CycleRecord<double>> CycleFileReader::next(std::size_t most) {
  const hsize_t count = std::min<hsize_t>(most, impl_->size - impl_->at);
  if (count == 0) return {};
  std::vector<CycleRow> rows(count);
  for_file(impl_->name, "cannot be read", [&] {
    const hdf5::Handle memory{H5Screate_simple(1, &count, nullptr), H5Sclose};
    hdf5::check(H5Dread(impl_->dataset.get(), impl_->type.get(), memory.get(),
                        stretch(impl_->dataset.get(), impl_->at, count).get(), H5P_DEFAULT, rows.data()));
  });
  impl_->at += count;
  std::vector<CycleRecord<double>> records;
  std::ranges::transform(rows, std::back_inserter(records), to_record);
  return records;
}

}  // namespace sextant
