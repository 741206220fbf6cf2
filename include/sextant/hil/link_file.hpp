#pragma once

#include <cstdint>
#include <string>

namespace sextant {

/// The file behind a link in shared memory, /dev/shm/<link>, and the locks on its bytes that mark the
/// attached sides; the kernel frees them at the end of their process. The file must be a regular file with
/// one name that belongs to this program's user and that no other user may reach: a program that writes it
/// drives the plant.
class LinkFile {
 public:
  /// One byte of the file each.
  enum class Lock : std::uint8_t { attaching, plant_is_there, drive_is_there };

  /// Opens the file, or makes it, with mode 0600. Throws std::runtime_error with one sentence that names it.
  explicit LinkFile(const std::string& link);
  LinkFile(const LinkFile&) = delete;
  LinkFile& operator=(const LinkFile&) = delete;
  ~LinkFile();

  [[nodiscard]] int descriptor() const noexcept { return file_; }
  /// For messages: "hil.link: the shared memory /dev/shm/<link>".
  [[nodiscard]] std::string sentence_start() const { return "hil.link: the shared memory /dev/shm" + name_; }

  /// Takes the lock where it is free now.
  [[nodiscard]] bool try_lock(Lock lock) const;
  /// Takes the lock, for which it waits 2 s; false where another program keeps it longer.
  [[nodiscard]] bool wait_for(Lock lock) const noexcept;
  /// The same; throws std::runtime_error where it is kept.
  void lock(Lock lock) const;
  void unlock(Lock lock) const noexcept;
  [[nodiscard]] bool is_held_by_another(Lock lock) const noexcept;

  /// Whether the file has been removed since it was opened.
  [[nodiscard]] bool is_removed() const;
  [[nodiscard]] std::int64_t bytes() const;
  /// Copies its first bytes; what lies beyond its end stays as it was.
  void read_beginning(void* to, std::size_t bytes) const;
  void resize(std::int64_t bytes) const;
  void remove() const noexcept;

  /// Throws std::runtime_error: what, and the reason that errno holds.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  [[nodiscard]] bool take(Lock lock) const noexcept;
  void open();
  void check_owner() const;

  std::string name_;  // with its leading slash
  int file_{-1};
};

}  // namespace sextant
