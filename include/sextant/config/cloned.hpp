#pragma once

#include <memory>
#include <utility>

namespace sextant {

/// Owner of an object of a class derived from `T`. A copy owns a copy of the object, by `T::clone()`; what is
/// moved from owns none.
template <class T>
class Cloned {
 public:
  explicit Cloned(std::unique_ptr<T> object) noexcept : object_{std::move(object)} {}
  Cloned(const Cloned& other) : object_{other.object_ ? other.object_->clone() : nullptr} {}
  Cloned(Cloned&& other) noexcept = default;
  Cloned& operator=(Cloned other) noexcept {
    object_ = std::move(other.object_);
    return *this;
  }
  ~Cloned() = default;

  [[nodiscard]] T& operator*() noexcept { return *object_; }
  [[nodiscard]] const T& operator*() const noexcept { return *object_; }
  [[nodiscard]] T* operator->() noexcept { return object_.get(); }
  [[nodiscard]] const T* operator->() const noexcept { return object_.get(); }

 private:
  std::unique_ptr<T> object_;
};

}  // namespace sextant
