#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>

namespace sextant {

/// A number that is read, whatever its type. It is bound by reference.
class NumberValue {
 public:
  template <std::floating_point T>
  NumberValue(const T& x) noexcept  // NOLINT(google-explicit-constructor): stands for the number
      : x_{&x}, get_{[](const void* from) { return double(*static_cast<const T*>(from)); }} {}
  template <std::floating_point T>
  NumberValue(const T&&) = delete;  // would be gone before it is read

  [[nodiscard]] double get() const noexcept { return get_(x_); }

 private:
  const void* x_;
  double (*get_)(const void*);
};

/// A number that may be set, whatever the type of the member that holds it. The member is bound by reference.
class NumberMember {
 public:
  /// As a number of units of that size.
  template <std::floating_point T>
  NumberMember(T& x, double unit = 1) noexcept  // NOLINT(google-explicit-constructor): stands for the member
      : x_{&x},
        unit_{unit},
        get_{[](const void* from, double size) {
          return std::optional{double(*static_cast<const T*>(from)) / size};
        }},
        set_{[](void* to, double value, double size) { *static_cast<T*>(to) = T(value * size); }} {}

  /// Not set: there is no number.
  template <std::floating_point T>
  NumberMember(std::optional<T>& x) noexcept  // NOLINT(google-explicit-constructor): stands for the member
      : x_{&x},
        get_{[](const void* from, double) -> std::optional<double> {
          return *static_cast<const std::optional<T>*>(from);
        }},
        set_{[](void* to, double value, double) { *static_cast<std::optional<T>*>(to) = T(value); }} {}

  /// A time that is held in whole nanoseconds, as a number of units of that length; beyond the range of its
  /// type it is the end of it. [ns]
  template <std::signed_integral I>
  NumberMember(I& ns, double unit_ns) noexcept
      : x_{&ns},
        unit_{unit_ns},
        get_{[](const void* from, double size) {
          return std::optional{double(*static_cast<const I*>(from)) / size};
        }},
        set_{[](void* to, double value, double size) { *static_cast<I*>(to) = whole<I>(value * size); }} {}

  /// Of a member for which infinity stands for no number.
  template <std::floating_point T>
  [[nodiscard]] static NumberMember unless_infinite(T& x) noexcept {
    NumberMember member{x};
    member.get_ = [](const void* from, double) -> std::optional<double> {
      const T value = *static_cast<const T*>(from);
      return std::isfinite(value) ? std::optional{double(value)} : std::nullopt;
    };
    return member;
  }

  [[nodiscard]] std::optional<double> get() const noexcept { return get_(x_, unit_); }
  void set(double value) const noexcept { set_(x_, value, unit_); }

 private:
  template <class I>
  [[nodiscard]] static I whole(double x) noexcept {
    constexpr auto most = double(std::numeric_limits<I>::max());
    constexpr auto least = double(std::numeric_limits<I>::min());
    if (x >= most) return std::numeric_limits<I>::max();
    if (x <= least) return std::numeric_limits<I>::min();
    return static_cast<I>(x < 0 ? x - 0.5 : x + 0.5);
  }

  void* x_;
  double unit_{1};
  std::optional<double> (*get_)(const void*, double);
  void (*set_)(void*, double, double);
};

/// An integer or an enumeration that may be set. The member is bound by reference.
class IntegerMember {
 public:
  template <class I>
    requires std::integral<I> || std::is_enum_v<I>
  IntegerMember(I& x) noexcept  // NOLINT(google-explicit-constructor): stands for the member
      : x_{&x},
        get_{[](const void* from) { return static_cast<std::int64_t>(*static_cast<const I*>(from)); }},
        set_{[](void* to, std::int64_t value) { *static_cast<I*>(to) = static_cast<I>(value); }} {}

  [[nodiscard]] std::int64_t get() const noexcept { return get_(x_); }
  void set(std::int64_t value) const noexcept { set_(x_, value); }

 private:
  void* x_;
  std::int64_t (*get_)(const void*);
  void (*set_)(void*, std::int64_t);
};

}  // namespace sextant
