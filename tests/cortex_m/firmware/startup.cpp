// From reset to run_firmware(): vector table, floating-point unit, memory, static objects; and what a program
// without heap and exceptions puts in the place of the library's versions, which would bring the heap and the
// unwinder along.
#include "startup.hpp"

#include <cstddef>
#include <cstdint>

extern "C" {
extern std::uint32_t stack_top, data_begin, data_end, data_in_flash, bss_begin, bss_end;
using Initialiser = void (*)();
extern Initialiser init_array_begin, init_array_end;

[[noreturn]] void reset_handler();
[[noreturn]] void halt() noexcept;
[[gnu::weak, noreturn]] void sys_tick_handler();

/// A pure virtual function was called: a call from a constructor, which no class here makes.
[[noreturn]] void __cxa_pure_virtual() {
  halt();
}
/// Nothing ever exits, so no destructor has to be remembered.
int __aeabi_atexit(void*, void (*)(void*), void*) {
  return 0;
}
void* __dso_handle = nullptr;
}

/// The deleting destructors in the tables of virtual functions name it; no object here comes from a heap.
void operator delete(void*) noexcept {
  halt();
}
void operator delete(void*, std::size_t) noexcept {
  halt();
}

namespace {

union Vector {
  std::uint32_t* stack;
  void (*handler)();
};

[[gnu::section(".vectors"), gnu::used]] const Vector vectors[16] = {
    {.stack = &stack_top},
    {.handler = reset_handler},
    {.handler = halt},  // NMI
    {.handler = halt},  // hard fault
    {.handler = halt},  // memory management
    {.handler = halt},  // bus fault
    {.handler = halt},  // usage fault
    {.handler = halt},
    {.handler = halt},
    {.handler = halt},
    {.handler = halt},
    {.handler = halt},  // SVCall
    {.handler = halt},  // debug monitor
    {.handler = halt},
    {.handler = halt},  // PendSV
    {.handler = sys_tick_handler},
};

constexpr std::uint32_t paint = 0xC0DE'C0DE;

}  // namespace

std::size_t stack_used() {
  const std::uint32_t* word = &bss_end;
  while (*word == paint) ++word;
  return std::size_t(&stack_top - word) * sizeof(std::uint32_t);
}

extern "C" void reset_handler() {
  // CPACR: full access to coprocessors 10 and 11, the floating-point unit (ARMv7-M Architecture, B3.2.20).
  *reinterpret_cast<volatile std::uint32_t*>(0xE000'ED88U) = 0xFU << 20U;
  asm volatile("dsb\n isb" ::: "memory");
  const std::uint32_t* from = &data_in_flash;
  for (std::uint32_t* to = &data_begin; to != &data_end; ++to, ++from) *to = *from;
  for (std::uint32_t* to = &bss_begin; to != &bss_end; ++to) *to = 0;
  const auto* const here = static_cast<const std::uint32_t*>(__builtin_frame_address(0)) - 64;
  for (std::uint32_t* to = &bss_end; to < here; ++to) *to = paint;
  for (const Initialiser* f = &init_array_begin; f != &init_array_end; ++f) (*f)();
  run_firmware();
}

extern "C" void sys_tick_handler() {
  halt();
}

extern "C" void halt() noexcept {
  for (;;) asm volatile("");
}
