#pragma once

#include <cstddef>
#include <cstdint>

/// Files and exit of the host that emulates this processor (or debugs it).
/// Source: Arm, Semihosting for AArch32 and AArch64, release 2023Q3.
namespace semihosting {

enum class Mode : std::uint32_t { read = 1, write = 5 };  ///< "rb" and "wb" of fopen

namespace detail {
inline std::int32_t call(std::uint32_t operation, const void* arguments) {
  register std::uint32_t r0 asm("r0") = operation;
  register const void* r1 asm("r1") = arguments;
  asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return std::int32_t(r0);
}
inline std::uint32_t address(const void* p) {
  return reinterpret_cast<std::uintptr_t>(p);
}
}  // namespace detail

/// A file of the host; `is_open()` is false when there is none.
class File {
 public:
  File(const char* name, Mode mode) {
    std::uint32_t length = 0;
    while (name[length] != '\0') ++length;
    const std::uint32_t arguments[3] = {detail::address(name), std::uint32_t(mode), length};
    handle_ = detail::call(0x01, arguments);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() {
    const std::uint32_t arguments[1] = {std::uint32_t(handle_)};
    if (is_open()) detail::call(0x02, arguments);
  }

  [[nodiscard]] bool is_open() const { return handle_ != -1; }
  /// True when all of it has been read.
  [[nodiscard]] bool read(void* to, std::size_t size) { return transfer(0x06, to, size); }
  /// True when all of it has been written.
  [[nodiscard]] bool write(const void* from, std::size_t size) { return transfer(0x05, from, size); }

 private:
  [[nodiscard]] bool transfer(std::uint32_t operation, const void* at, std::size_t size) {
    const std::uint32_t arguments[3] = {std::uint32_t(handle_), detail::address(at), size};
    return detail::call(operation, arguments) == 0;  // bytes that were not transferred
  }

  std::int32_t handle_{};
};

inline void print(const char* text) {
  detail::call(0x04, text);
}

/// Ends the emulation; the host sees exit status 0 or 1.
[[noreturn]] inline void exit(bool good) {
  const std::uint32_t reason = good ? 0x20026U : 0x20024U;  // application exit, run-time error
  detail::call(0x18, reinterpret_cast<const void*>(reason));
  for (;;) asm volatile("");
}

}  // namespace semihosting
