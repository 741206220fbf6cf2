#include "sextant/sim/cycle_file.hpp"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

#include <hdf5.h>

#include "cycle_row.hpp"
#include "hdf5_handle.hpp"

namespace sextant {
namespace {

constexpr const char* dataset_name = "cycles";
constexpr const char* configuration_name = "configuration";
constexpr const char* version_name = "sextant_version";
constexpr const char* dropped_name = "dropped";
constexpr hsize_t chunk_rows = 1024;
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

std::string read_text(hid_t file, const char* name) {
  const hdf5::Handle dataset{H5Dopen2(file, name, H5P_DEFAULT), H5Dclose};
  const hdf5::Handle type{H5Dget_type(dataset.get()), H5Tclose};
  std::string text(H5Tget_size(type.get()), '\0');
  hdf5::check(H5Dread(dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()));
  text.resize(std::min(text.find('\0'), text.size()));
  return text;
}

hdf5::Handle growing_dataset(hid_t file, hid_t type) {
  const hdf5::Handle properties{H5Pcreate(H5P_DATASET_CREATE), H5Pclose};
  const hsize_t chunk = chunk_rows;
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
  hdf5::Handle file{};
  hdf5::Handle type{};
  hdf5::Handle dataset{};
  std::vector<CycleRow> rows{};
  hsize_t written{0};
};

CycleFileWriter::CycleFileWriter(const std::string& file, const std::string& configuration)
    : impl_{std::make_unique<Impl>()} {
  impl_->name = file;
  for_file(file, "cannot be written", [&] {
    impl_->file = {H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose};
    hdf5::write_attribute(impl_->file.get(), version_name, SEXTANT_VERSION);
    write_text(impl_->file.get(), configuration_name, configuration);
    impl_->type = cycle_row_type();
    impl_->dataset = growing_dataset(impl_->file.get(), impl_->type.get());
    hdf5::check(H5Fflush(impl_->file.get(), H5F_SCOPE_GLOBAL));
  });
}

CycleFileWriter::~CycleFileWriter() = default;

void CycleFileWriter::append(std::span<const CycleRecord<double>> records) {
  impl_->rows.clear();
  std::ranges::transform(records, std::back_inserter(impl_->rows), to_row);
  const hsize_t count = impl_->rows.size();
  for_file(impl_->name, "cannot be written", [&] {
    const hsize_t extent = impl_->written + count;
    hdf5::check(H5Dset_extent(impl_->dataset.get(), &extent));
    const hdf5::Handle memory{H5Screate_simple(1, &count, nullptr), H5Sclose};
    hdf5::check(H5Dwrite(impl_->dataset.get(), impl_->type.get(), memory.get(),
                         stretch(impl_->dataset.get(), impl_->written, count).get(), H5P_DEFAULT,
                         impl_->rows.data()));
  });
  impl_->written += count;
}

void CycleFileWriter::close(std::uint64_t dropped) {
  for_file(impl_->name, "cannot be written", [&] {
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
  long long dropped{0};
};

namespace {

std::string version_of(hid_t file) {
  const hdf5::Handle attribute{H5Aopen(file, version_name, H5P_DEFAULT), H5Aclose};
  const hdf5::Handle type{H5Aget_type(attribute.get()), H5Tclose};
  std::string text(H5Tget_size(type.get()), '\0');
  hdf5::check(H5Aread(attribute.get(), type.get(), text.data()));
  text.resize(std::min(text.find('\0'), text.size()));
  return text;
}

/// A file that was not closed has none.
long long dropped_of(hid_t file) {
  if (H5Aexists(file, dropped_name) <= 0) return 0;
  const hdf5::Handle attribute{H5Aopen(file, dropped_name, H5P_DEFAULT), H5Aclose};
  long long dropped = 0;
  hdf5::check(H5Aread(attribute.get(), H5T_NATIVE_LLONG, &dropped));
  return dropped;
}

}  // namespace

CycleFileReader::CycleFileReader(const std::string& file) : impl_{std::make_unique<Impl>()} {
  impl_->name = file;
  for_file(file, "is no recording of control periods (sextant-ecu --record-cycles)", [&] {
    impl_->file = {H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
    impl_->dataset = {H5Dopen2(impl_->file.get(), dataset_name, H5P_DEFAULT), H5Dclose};
    impl_->type = cycle_row_type();
    const hdf5::Handle stored{H5Dget_type(impl_->dataset.get()), H5Tclose};
    if (H5Tget_nmembers(stored.get()) != H5Tget_nmembers(impl_->type.get())) {
      throw std::runtime_error{"its rows are of another version of Sextant"};
    }
    impl_->configuration = read_text(impl_->file.get(), configuration_name);
    impl_->version = version_of(impl_->file.get());
    impl_->dropped = dropped_of(impl_->file.get());
    const hdf5::Handle space{H5Dget_space(impl_->dataset.get()), H5Sclose};
    hdf5::check(H5Sget_simple_extent_dims(space.get(), &impl_->size, nullptr));
  });
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

std::uint64_t CycleFileReader::dropped() const noexcept {
  return static_cast<std::uint64_t>(impl_->dropped);
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
