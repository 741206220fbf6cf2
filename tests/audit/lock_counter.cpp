#include "audit/lock_counter.hpp"

#include <dlfcn.h>
#include <pthread.h>
#include <semaphore.h>

namespace {

thread_local std::uint64_t count = 0;

/// The C library's function of that name.
template <class Function>
Function* next(const char* name) noexcept {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

// Resolved at the first call of each, which for those that matter is before the audit begins.
#define SEXTANT_COUNTED(name, Type)                    \
  extern "C" int name(Type* object) noexcept {         \
    static auto* const real = next<int(Type*)>(#name); \
    ++count;                                           \
    return real(object);                               \
  }

SEXTANT_COUNTED(pthread_mutex_lock, pthread_mutex_t)
SEXTANT_COUNTED(pthread_mutex_trylock, pthread_mutex_t)
SEXTANT_COUNTED(pthread_rwlock_rdlock, pthread_rwlock_t)
SEXTANT_COUNTED(pthread_rwlock_wrlock, pthread_rwlock_t)

extern "C" int pthread_spin_lock(pthread_spinlock_t* object) noexcept {
  static auto* const real = next<int(pthread_spinlock_t*)>("pthread_spin_lock");
  ++count;
  return real(object);
}

extern "C" int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  static auto* const real = next<int(pthread_cond_t*, pthread_mutex_t*)>("pthread_cond_wait");
  ++count;
  return real(condition, mutex);
}

extern "C" int sem_wait(sem_t* semaphore) {
  static auto* const real = next<int(sem_t*)>("sem_wait");
  ++count;
  return real(semaphore);
}

namespace sextant::audit {

std::uint64_t locks() noexcept {
  return count;
}

}  // namespace sextant::audit
