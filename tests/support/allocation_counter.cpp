#include "support/allocation_counter.hpp"

#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

namespace sextant::testing {
bool allocations_are_counted() noexcept {
  return false;
}
std::uint64_t allocations() noexcept {
  return 0;
}
}  // namespace sextant::testing

#else

namespace {
thread_local std::uint64_t count = 0;
}

// glibc takes the program's own malloc for every library when the program has one.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t n, std::size_t size);
void* __libc_realloc(void* p, std::size_t size);

void* malloc(std::size_t size) {
  ++count;
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  ++count;
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t size) {
  ++count;
  return __libc_realloc(p, size);
}
}

namespace sextant::testing {
bool allocations_are_counted() noexcept {
  return true;
}
std::uint64_t allocations() noexcept {
  return count;
}
}  // namespace sextant::testing

#endif
