#include "growing_file.hpp"

#include <stdexcept>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

namespace sextant::hdf5 {
namespace {

/// Freed space in the file is not used again, so that the data of a flush stays readable during the next
/// flush, and after one that was interrupted.
Handle append_only() {
  Handle properties{H5Pcreate(H5P_FILE_CREATE), H5Pclose};
  check(H5Pset_file_space_strategy(properties.get(), H5F_FSPACE_STRATEGY_NONE, false, 1));
  return properties;
}

/// Headers and attributes of HDF5 1.8, which have checksums, and none of the newest: a file of theirs that
/// was not closed is not opened again.
Handle with_checksums() {
  Handle properties{H5Pcreate(H5P_FILE_ACCESS), H5Pclose};
  check(H5Pset_libver_bounds(properties.get(), H5F_LIBVER_V18, H5F_LIBVER_LATEST));
  return properties;
}

}  // namespace

GrowingFile::GrowingFile(const std::string& name) {
  // HDF5's own clean-up at exit crashes on a file that could not be written to its end; `close` needs none.
  H5dont_atexit();
  file_ = {H5Fcreate(name.c_str(), H5F_ACC_TRUNC, append_only().get(), with_checksums().get()), H5Fclose};
}

int GrowingFile::descriptor() const {
  void* descriptor = nullptr;
  check(H5Fget_vfd_handle(file_.get(), H5P_DEFAULT, &descriptor));
  return *static_cast<int*>(descriptor);
}

off_t GrowingFile::size() const {
  hsize_t bytes = 0;
  check(H5Fget_filesize(file_.get(), &bytes));
  return static_cast<off_t>(bytes);
}

// HDF5 writes its index even where the data before it found no room, which loses the whole file. So the room
// is taken first.
void GrowingFile::reserve_space(std::size_t bytes) {
  if (const int error = ::posix_fallocate(descriptor(), size(), static_cast<off_t>(bytes))) {
    throw std::runtime_error{std::generic_category().message(error)};
  }
}

// Room that stays behind does no harm, so that failing here ends nothing.
void GrowingFile::trim_space() {
  if (::ftruncate(descriptor(), size()) != 0) return;
}

}  // namespace sextant::hdf5
