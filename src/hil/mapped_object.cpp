#include "sextant/hil/mapped_object.hpp"

#include <cerrno>
#include <system_error>

#include <sys/mman.h>

namespace sextant {

MappedPages::MappedPages(std::size_t bytes)
    : begin_{mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)},
      bytes_{bytes} {
  if (begin_ == MAP_FAILED) throw std::system_error(errno, std::generic_category());
}

MappedPages::~MappedPages() {
  munmap(begin_, bytes_);
}

void MappedPages::become(int file) {
  constexpr int flags = MAP_SHARED | MAP_FIXED | MAP_POPULATE;
  if (mmap(begin_, bytes_, PROT_READ | PROT_WRITE, flags, file, 0) == MAP_FAILED) {
    throw std::system_error(errno, std::generic_category());
  }
}

}  // namespace sextant
