#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>

namespace sextant {

/// Memory for an object that lies in a file, as pages.
class MappedPages {
 public:
  /// Pages of this process alone, all zero. Throws std::system_error.
  explicit MappedPages(std::size_t bytes);
  MappedPages(const MappedPages&) = delete;
  MappedPages& operator=(const MappedPages&) = delete;
  ~MappedPages();

  /// Replaces the pages by those of the file, shared with every process that maps it, at the same address.
  /// Throws std::system_error.
  void become(int file);

  [[nodiscard]] void* begin() const noexcept { return begin_; }

 private:
  void* begin_;
  std::size_t bytes_;
};

/// An object of type T in a file that other processes map too. Its lifetime begins in this process by its
/// constructor, in pages of its own, and the file's pages then take their place: the object has begun, and
/// its value is the file's, as if another thread had written it. A T may hold atomics, whose lifetime no cast
/// of the mapped bytes would begin, and nothing is written into memory that another process uses.
template <class T>
class MappedObject {
  static_assert(std::is_trivially_destructible_v<T>, "another process may go on using the object");
  static_assert(alignof(T) <= 4096, "pages are aligned to 4096 bytes at least");

 public:
  /// The file holds at least sizeof(T) bytes, which are a T's; it may be closed afterwards. Throws
  /// std::system_error.
  explicit MappedObject(int file) : pages_{sizeof(T)}, object_{new (pages_.begin()) T{}} {
    pages_.become(file);
    object_ = std::launder(object_);
  }

  /// Reconstructs the object; to be called while no other process uses it.
  void renew() { object_ = std::construct_at(object_); }

  [[nodiscard]] T& get() const noexcept { return *object_; }

 private:
  MappedPages pages_;
  T* object_;
};

}  // namespace sextant
