#pragma once

#include <cstddef>
#include <string>
#include <utility>

#include <sys/types.h>

#include "hdf5_handle.hpp"

namespace sextant::hdf5 {

/// An HDF5 file that is whole in itself after each write: also where the disk is full or the process is
/// killed between two writes.
class GrowingFile {
 public:
  GrowingFile() noexcept = default;
  /// Replaces the file. Throws std::runtime_error with the reason where it cannot be created.
  explicit GrowingFile(const std::string& name);

  [[nodiscard]] hid_t get() const noexcept { return file_.get(); }
  /// False before it is created, once it is closed, and once it is abandoned.
  [[nodiscard]] explicit operator bool() const noexcept { return bool(file_); }

  /// Runs something that writes no more than so many bytes of data, and flushes the file. Throws
  /// std::runtime_error with the reason; the file must be abandoned then.
  template <class Write>
  void write(std::size_t bytes, Write&& write) {
    reserve_space(bytes);
    std::forward<Write>(write)();
    flush();
    trim_space();
  }
  void flush() { check(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL)); }

  /// Throws std::runtime_error with the reason.
  void close() { file_.close(); }
  /// Lets go without a further write, which would go over what the last flush left whole. What was opened in
  /// the file must be released too.
  void abandon() noexcept { file_.release(); }

 private:
  [[nodiscard]] int descriptor() const;
  [[nodiscard]] off_t size() const;
  void reserve_space(std::size_t bytes);
  void trim_space();

  Handle file_{};
};

}  // namespace sextant::hdf5
