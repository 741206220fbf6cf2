#include "audit/system_call_trap.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <stdexcept>
#include <system_error>

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

namespace sextant::audit {
namespace {

std::atomic<std::uint64_t> caught{0};
std::atomic<bool> counting{true};
std::array<std::atomic<int>, 16> numbers{};

struct Name {
  int number;
  const char* name;
};

/// Those that a real-time loop is likely to make by mistake.
constexpr std::array names{Name{SYS_read, "read"},
                           Name{SYS_write, "write"},
                           Name{SYS_mmap, "mmap"},
                           Name{SYS_munmap, "munmap"},
                           Name{SYS_mprotect, "mprotect"},
                           Name{SYS_madvise, "madvise"},
                           Name{SYS_brk, "brk"},
                           Name{SYS_futex, "futex"},
                           Name{SYS_ioctl, "ioctl"},
                           Name{SYS_clock_gettime, "clock_gettime"},
                           Name{SYS_clock_nanosleep, "clock_nanosleep"},
                           Name{SYS_nanosleep, "nanosleep"},
                           Name{SYS_sched_yield, "sched_yield"},
                           Name{SYS_gettid, "gettid"},
                           Name{SYS_getpid, "getpid"},
                           Name{SYS_sendto, "sendto"},
                           Name{SYS_sendmsg, "sendmsg"},
                           Name{SYS_recvmsg, "recvmsg"},
                           Name{SYS_getrusage, "getrusage"}};

std::string name_of(int number) {
  const auto* const found = std::ranges::find(names, number, &Name::number);
  return found != names.end() ? found->name : "call number " + std::to_string(number);
}

void on_trap(int, siginfo_t* info, void* context) {
  auto& machine = static_cast<ucontext_t*>(context)->uc_mcontext;
#if defined(__x86_64__)
  machine.gregs[REG_RAX] = -ENOSYS;
#elif defined(__aarch64__)
  machine.regs[0] = static_cast<unsigned long long>(-ENOSYS);
#else
#error "say where this architecture returns the result of a system call"
#endif
  if (!counting.load(std::memory_order_relaxed)) return;
  const std::uint64_t index = caught.fetch_add(1, std::memory_order_relaxed);
  if (index < numbers.size()) numbers[index].store(info->si_syscall, std::memory_order_relaxed);
}

void install_handler() {
  struct sigaction action{};
  action.sa_sigaction = on_trap;
  action.sa_flags = SA_SIGINFO;
  if (sigaction(SIGSYS, &action, nullptr) != 0) {
    throw std::system_error(errno, std::generic_category(), "SIGSYS cannot be handled");
  }
}

}  // namespace

void trap_system_calls(bool may_sleep) {
#if defined(__x86_64__)
  constexpr std::uint32_t architecture = AUDIT_ARCH_X86_64;
#else
  constexpr std::uint32_t architecture = AUDIT_ARCH_AARCH64;
#endif
  install_handler();
  const std::uint32_t sleeping = static_cast<std::uint32_t>(may_sleep ? SYS_clock_nanosleep : SYS_exit);
  std::array filter{sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, arch)),
                    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, architecture, 0, 6),
                    sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
                    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, sleeping, 3, 0),
                    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit, 2, 0),
                    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit_group, 1, 0),
                    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_rt_sigreturn, 0, 1),
                    sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
                    sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP)};
  const sock_fprog program{static_cast<unsigned short>(filter.size()), filter.data()};
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
      prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program, 0, 0) != 0) {
    throw std::system_error(errno, std::generic_category(),
                            "the kernel takes no filter of system calls (seccomp)");
  }
}

void stop_counting_system_calls() noexcept {
  counting.store(false, std::memory_order_relaxed);
}

std::uint64_t trapped_system_calls() noexcept {
  return caught.load(std::memory_order_relaxed);
}

std::vector<std::string> trapped_names() {
  std::vector<std::string> result;
  const std::size_t known = std::min<std::size_t>(trapped_system_calls(), numbers.size());
  for (std::size_t i = 0; i < known; ++i) result.push_back(name_of(numbers[i].load()));
  return result;
}

}  // namespace sextant::audit
