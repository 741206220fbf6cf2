#include "sextant/hil/link_file.hpp"

#include <cerrno>
#include <chrono>
#include <cstddef>
#include <stdexcept>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace sextant {
namespace {

using namespace std::chrono_literals;

constexpr int lock_tries = 200;
constexpr auto between_tries = 10ms;
constexpr mode_t of_other_users = S_IRWXG | S_IRWXO;

flock on_byte(LinkFile::Lock byte, short type) {
  flock lock{};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = static_cast<off_t>(byte);
  lock.l_len = 1;
  return lock;
}

bool another_has_it(int error) {
  return error == EAGAIN || error == EACCES;
}

struct stat status_of(const LinkFile& file) {
  struct stat status{};
  if (fstat(file.descriptor(), &status) != 0) file.fail("cannot be examined");
  return status;
}

std::string octal(mode_t mode) {
  std::string digits = "0";
  for (const unsigned shift : {6U, 3U, 0U}) digits += static_cast<char>('0' + (mode >> shift & 7U));
  return digits;
}

std::string of_another_user(uid_t owner) {
  return " belongs to another user (id " + std::to_string(owner) + "; this program runs as " +
         std::to_string(geteuid()) + "): run both sides as one user, or remove it, or choose another name";
}

constexpr const char* remedy = ": stop the program that uses it and remove it, or choose another name";

}  // namespace

LinkFile::LinkFile(const std::string& link) : name_{"/" + link} {
  try {
    open();
    check_owner();
  } catch (...) {
    if (file_ >= 0) close(file_);
    throw;
  }
}

LinkFile::~LinkFile() {
  close(file_);
}

/// One call either creates the file or opens an existing one, so that the caller can distinguish the two.
void LinkFile::open() {
  constexpr int access = O_RDWR | O_CLOEXEC | O_NOFOLLOW;
  bool removed_meanwhile = true;
  while (file_ < 0 && removed_meanwhile) {
    file_ = shm_open(name_.c_str(), access | O_CREAT | O_EXCL, S_IRUSR | S_IWUSR);
    removed_meanwhile = file_ < 0 && errno == EEXIST;
    if (removed_meanwhile) file_ = shm_open(name_.c_str(), access, 0);
    removed_meanwhile = removed_meanwhile && file_ < 0 && errno == ENOENT;
  }
  if (file_ >= 0) return;
  const int error = errno;
  struct stat status{};
  if (error == EACCES && lstat(("/dev/shm" + name_).c_str(), &status) == 0 && status.st_uid != geteuid()) {
    throw std::runtime_error(sentence_start() + of_another_user(status.st_uid));
  }
  errno = error;
  fail("cannot be opened");
}

void LinkFile::check_owner() const {
  const struct stat status = status_of(*this);
  if (status.st_uid != geteuid()) throw std::runtime_error(sentence_start() + of_another_user(status.st_uid));
  if (!S_ISREG(status.st_mode)) throw std::runtime_error(sentence_start() + " is no regular file" + remedy);
  if ((status.st_mode & of_other_users) != 0) {
    throw std::runtime_error(sentence_start() + " may be reached by other users (mode " +
                             octal(status.st_mode) + ")" + remedy);
  }
  if (status.st_nlink > 1) {
    throw std::runtime_error(sentence_start() + " has " + std::to_string(status.st_nlink) + " names" +
                             remedy);
  }
}

bool LinkFile::take(Lock lock) const noexcept {
  const flock wanted = on_byte(lock, F_WRLCK);
  return fcntl(file_, F_OFD_SETLK, &wanted) == 0;
}

bool LinkFile::try_lock(Lock lock) const {
  if (take(lock)) return true;
  if (!another_has_it(errno)) fail("cannot be locked");
  return false;
}

bool LinkFile::wait_for(Lock lock) const noexcept {
  for (int n = 0; n < lock_tries; ++n) {
    if (n > 0) std::this_thread::sleep_for(between_tries);
    if (take(lock)) return true;
    if (!another_has_it(errno)) return false;
  }
  return false;
}

void LinkFile::lock(Lock lock) const {
  if (wait_for(lock)) return;
  if (!another_has_it(errno)) fail("cannot be locked");
  throw std::runtime_error(sentence_start() +
                           " is locked by another program, which does not release it: stop "
                           "that one (fuser /dev/shm" +
                           name_ + " lists it), or choose another name");
}

void LinkFile::unlock(Lock lock) const noexcept {
  const flock wanted = on_byte(lock, F_UNLCK);
  (void)fcntl(file_, F_OFD_SETLK, &wanted);
}

bool LinkFile::is_held_by_another(Lock lock) const noexcept {
  flock wanted = on_byte(lock, F_WRLCK);
  return fcntl(file_, F_OFD_GETLK, &wanted) == 0 && wanted.l_type != F_UNLCK;
}

bool LinkFile::is_removed() const {
  return status_of(*this).st_nlink == 0;
}

std::int64_t LinkFile::bytes() const {
  return status_of(*this).st_size;
}

void LinkFile::read_beginning(void* to, std::size_t count) const {
  if (pread(file_, to, count, 0) < 0) fail("cannot be read");
}

void LinkFile::resize(std::int64_t size) const {
  // A size alone takes no room: a page that finds none later would end the program by SIGBUS.
  if (ftruncate(file_, size) != 0) fail("finds no room");
  const int error = size > 0 ? posix_fallocate(file_, 0, size) : 0;
  if (error == 0) return;
  (void)ftruncate(file_, 0);
  errno = error;
  fail("finds no room");
}

void LinkFile::remove() const noexcept {
  shm_unlink(name_.c_str());
}

void LinkFile::fail(const std::string& what) const {
  const std::string reason = std::generic_category().message(errno);
  throw std::runtime_error(sentence_start() + " " + what + ": " + reason);
}

}  // namespace sextant
