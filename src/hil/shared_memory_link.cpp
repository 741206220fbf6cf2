#include "sextant/hil/shared_memory_link.hpp"

#include <atomic>
#include <cerrno>
#include <cstring>
#include <new>
#include <stdexcept>
#include <system_error>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace sextant {
namespace {

// One byte of the file each; the kernel frees them when their process is gone.
constexpr off_t attaching = 0;
constexpr off_t plant_is_there = 1;
constexpr off_t drive_is_there = 2;

flock byte_lock(short type, off_t byte) {
  flock lock{};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = byte;
  lock.l_len = 1;
  return lock;
}

off_t byte_of(LinkRole role) {
  return role == LinkRole::plant ? plant_is_there : drive_is_there;
}

bool is_held_by_another(int file, off_t byte) {
  flock lock = byte_lock(F_WRLCK, byte);
  return fcntl(file, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

const char* name_of(LinkRole role) {
  return role == LinkRole::plant ? "plant" : "drive";
}

const char* remedy_for_open(int error) {
  return error == EACCES ? "; another user made it: run both sides as one user, or remove it" : "";
}

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what + ": " + std::generic_category().message(errno));
}

}  // namespace

SharedMemoryLink::SharedMemoryLink(const HilParameters& parameters, LinkRole role, std::int64_t period_ns)
    : name_{"/" + parameters.link}, role_{role} {
  try {
    // The last of a run may remove the memory between our opening and locking it.
    while (!try_attach(parameters, period_ns)) release();
  } catch (...) {
    release();
    throw;
  }
}

void SharedMemoryLink::say_goodbye() noexcept {
  if (role_ == LinkRole::drive) memory_->gate_enable.store(0, std::memory_order_release);
  own().present.store(0, std::memory_order_release);
}

SharedMemoryLink::~SharedMemoryLink() {
  say_goodbye();
  flock lock = byte_lock(F_WRLCK, attaching);
  (void)fcntl(file_, F_OFD_SETLKW, &lock);
  if (!other_is_attached()) shm_unlink(name_.c_str());
  release();
}

bool SharedMemoryLink::try_attach(const HilParameters& parameters, std::int64_t period_ns) {
  file_ = shm_open(name_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (file_ < 0) {
    const int error = errno;
    throw std::runtime_error("hil.link: the shared memory /dev/shm" + name_ + " cannot be opened: " +
                             std::generic_category().message(error) + remedy_for_open(error));
  }
  flock lock = byte_lock(F_WRLCK, attaching);
  if (fcntl(file_, F_OFD_SETLKW, &lock) != 0) fail("hil.link: /dev/shm" + name_ + " cannot be locked");
  struct stat status{};
  if (fstat(file_, &status) != 0) fail("hil.link: /dev/shm" + name_ + " cannot be examined");
  if (status.st_nlink == 0) return false;
  LinkHeader found{};
  if (status.st_size > 0 && pread(file_, &found, sizeof found, 0) < 0) {
    fail("hil.link: /dev/shm" + name_ + " cannot be read");
  }
  const bool is_new = !check_header(found, status.st_size);
  lock = byte_lock(F_WRLCK, byte_of(role_));
  if (fcntl(file_, F_OFD_SETLK, &lock) != 0) {
    if (errno != EAGAIN && errno != EACCES) fail("hil.link: /dev/shm" + name_ + " cannot be locked");
    throw std::runtime_error(std::string{"hil.link: \""} + parameters.link + "\" already has a " +
                             name_of(role_) + "; stop that one, or choose another name for both sides");
  }
  if (is_new && ftruncate(file_, sizeof(LinkMemory)) != 0) {
    fail("hil.link: there is no room for /dev/shm" + name_);
  }
  map();
  join(parameters, period_ns);
  lock = byte_lock(F_UNLCK, attaching);
  (void)fcntl(file_, F_OFD_SETLK, &lock);
  return true;
}

bool SharedMemoryLink::check_header(const LinkHeader& found, std::int64_t file_bytes) const {
  if (file_bytes == 0) return false;
  // A start that was killed before it had written the header; the size tells it from a foreign file.
  const bool was_never_made = found.magic == 0 && file_bytes == std::int64_t{sizeof(LinkMemory)};
  if (was_never_made && !other_is_attached()) return false;
  const std::string memory = "hil.link: the shared memory /dev/shm" + name_;
  const std::string remedy = "; stop the program that uses it and remove it, or choose another name";
  if (found.magic != link_magic) throw std::runtime_error(memory + " is none of Sextant's" + remedy);
  if (found.layout_version != link_layout_version) {
    throw std::runtime_error(memory + " has layout version " + std::to_string(found.layout_version) +
                             ", this program has " + std::to_string(link_layout_version) + remedy);
  }
  if (found.size_bytes != sizeof(LinkMemory) || file_bytes != std::int64_t{sizeof(LinkMemory)}) {
    throw std::runtime_error(memory + " has a size of " + std::to_string(file_bytes) + " bytes and says " +
                             std::to_string(found.size_bytes) + ", this program needs " +
                             std::to_string(sizeof(LinkMemory)) + remedy);
  }
  return true;
}

void SharedMemoryLink::map() {
  void* const place =
      mmap(nullptr, sizeof(LinkMemory), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file_, 0);
  if (place == MAP_FAILED) fail("hil.link: /dev/shm" + name_ + " cannot be mapped");
  memory_ = static_cast<LinkMemory*>(place);
}

void SharedMemoryLink::join(const HilParameters& parameters, std::int64_t period_ns) {
  const auto pacing = static_cast<std::uint32_t>(parameters.pacing);
  if (other_is_attached()) {
    const LinkHeader& theirs = memory_->header;
    if (theirs.period_ns != period_ns) {
      throw std::runtime_error("hil.link: the other side of \"" + parameters.link +
                               "\" runs with a period of " + std::to_string(theirs.period_ns) +
                               " ns, this one with " + std::to_string(period_ns) + " ns; give both the same");
    }
    if (theirs.pacing != pacing) {
      throw std::runtime_error("hil.pacing: one side of \"" + parameters.link +
                               "\" runs in real time and the other in lockstep; give both the same");
    }
  } else {
    // Nobody is there: what is left of an earlier run is of no use.
    const std::uint32_t plants = memory_->plant.generation.load(std::memory_order_relaxed);
    const std::uint32_t drives = memory_->drive.generation.load(std::memory_order_relaxed);
    new (memory_) LinkMemory{};
    memory_->plant.generation.store(plants, std::memory_order_relaxed);
    memory_->drive.generation.store(drives, std::memory_order_relaxed);
    memory_->header = {0, link_layout_version, sizeof(LinkMemory), period_ns, pacing, 0};
    // Last, so that who is killed before leaves memory that was never made.
    std::atomic_signal_fence(std::memory_order_seq_cst);
    memory_->header.magic = link_magic;
  }
  if (role_ == LinkRole::drive) memory_->gate_enable.store(0, std::memory_order_release);
  generation_ = own().generation.load(std::memory_order_relaxed) + 1;
  own().asleep.store(0, std::memory_order_relaxed);
  own().generation.store(generation_, std::memory_order_release);
  own().present.store(1, std::memory_order_release);
}

LinkSide& SharedMemoryLink::own() const noexcept {
  return role_ == LinkRole::plant ? memory_->plant : memory_->drive;
}

LinkSide& SharedMemoryLink::other() const noexcept {
  return role_ == LinkRole::plant ? memory_->drive : memory_->plant;
}

bool SharedMemoryLink::other_is_attached() const noexcept {
  return is_held_by_another(file_, role_ == LinkRole::plant ? drive_is_there : plant_is_there);
}

void SharedMemoryLink::release() noexcept {
  if (memory_ != nullptr) munmap(memory_, sizeof(LinkMemory));
  if (file_ >= 0) close(file_);
  memory_ = nullptr;
  file_ = -1;
}

}  // namespace sextant
