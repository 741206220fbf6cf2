#pragma once

#include <cassert>
#include <cstddef>
#include <cstring>
#include <vector>

#include "hdf5_handle.hpp"
#include "trace_columns.hpp"

namespace sextant {

/// One signal of a trace: a dataset that grows, and the values that wait for being written.
class TraceColumnWriter {
 public:
  /// Creates the dataset, and room for as many values to wait. Throws std::runtime_error with HDF5's reason.
  TraceColumnWriter(hid_t group, const TraceColumn& column, hid_t properties, std::size_t rows);

  /// Keeps this column's value of a row; there must be room.
  void push(const TraceRow& row) noexcept {
    assert(waiting_.size() - end_ >= column_->size);
    const auto* value = reinterpret_cast<const std::byte*>(&row) + column_->offset;
    // Most columns are of doubles; a constant size avoids the call of memcpy.
    if (column_->size == sizeof(double)) {
      std::memcpy(&waiting_[end_], value, sizeof(double));
    } else {
      std::memcpy(&waiting_[end_], value, column_->size);
    }
    end_ += column_->size;
  }

  /// Writes the values kept behind the first `written` ones and lets go of them. Throws std::runtime_error
  /// with HDF5's reason.
  void write(hsize_t written);

  /// Throws std::runtime_error with HDF5's reason.
  void close() { dataset_.close(); }

  /// Gives the dataset up without closing it.
  void abandon() noexcept { dataset_.release(); }

 private:
  const TraceColumn* column_;
  hdf5::Handle type_;
  hdf5::Handle dataset_;
  std::vector<std::byte> waiting_;
  std::size_t end_{0};  // of the values in `waiting_` [byte]
};

}  // namespace sextant
