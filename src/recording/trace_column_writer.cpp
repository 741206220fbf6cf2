#include "trace_column_writer.hpp"

#include <stdexcept>

namespace sextant {
namespace {

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
    case ColumnType::int8:
      return {H5Tcopy(H5T_NATIVE_INT8), H5Tclose};
    case ColumnType::drive_state:
      return drive_state_type();
  }
  throw std::logic_error{"a column of unknown type"};
}

}  // namespace

TraceColumnWriter::TraceColumnWriter(hid_t group, const TraceColumn& column, hid_t properties,
                                     std::size_t rows)
    : column_{&column}, type_{memory_type(column.type)}, waiting_(rows * column.size) {
  const hsize_t none = 0;
  const hsize_t unlimited = H5S_UNLIMITED;
  const hdf5::Handle space{H5Screate_simple(1, &none, &unlimited), H5Sclose};
  dataset_ = {H5Dcreate2(group, column.name, type_.get(), space.get(), H5P_DEFAULT, properties, H5P_DEFAULT),
              H5Dclose};
  hdf5::write_attribute(dataset_.get(), "unit", column.unit);
  hdf5::write_attribute(dataset_.get(), "description", column.description);
}

void TraceColumnWriter::write(hsize_t written) {
  const hsize_t count = end_ / column_->size;
  const hsize_t extent = written + count;
  hdf5::check(H5Dset_extent(dataset_.get(), &extent));
  const hdf5::Handle file_space{H5Dget_space(dataset_.get()), H5Sclose};
  hdf5::check(H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, &written, nullptr, &count, nullptr));
  const hdf5::Handle memory_space{H5Screate_simple(1, &count, nullptr), H5Sclose};
  hdf5::check(H5Dwrite(dataset_.get(), type_.get(), memory_space.get(), file_space.get(), H5P_DEFAULT,
                       waiting_.data()));
  end_ = 0;
}

}  // namespace sextant
