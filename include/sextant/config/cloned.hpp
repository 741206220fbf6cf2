#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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

/// Parts among which a configuration chooses by `name()`.
template <class Part>
using Parts = std::vector<Cloned<Part>>;

/// The same parts with their parameters before a file has been read.
template <class Part>
[[nodiscard]] Parts<Part> untouched(const Parts<Part>& parts) {
  Parts<Part> fresh;
  fresh.reserve(parts.size());
  for (const auto& part : parts) fresh.emplace_back(part->untouched());
  return fresh;
}

/// The part of that name. Throws std::logic_error where there is none; kind: as that names it.
template <class Part>
[[nodiscard]] const Part& named(const Parts<Part>& parts, std::string_view name, const char* kind) {
  for (const auto& part : parts) {
    if (part->name() == name) return *part;
  }
  throw std::logic_error(std::string{"there is no "} + kind + " \"" + std::string{name} + "\"");
}

}  // namespace sextant
