#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

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

  /// The same of a time that may be left out.
  template <std::signed_integral I>
  NumberMember(std::optional<I>& ns, double unit_ns) noexcept
      : x_{&ns},
        unit_{unit_ns},
        get_{[](const void* from, double size) -> std::optional<double> {
          const auto& time = *static_cast<const std::optional<I>*>(from);
          return time ? std::optional{double(*time) / size} : std::nullopt;
        }},
        set_{[](void* to, double value, double size) {
          *static_cast<std::optional<I>*>(to) = whole<I>(value * size);
        }} {}

  /// The same of a time for which the last one of its type stands for none.
  template <std::signed_integral I>
  [[nodiscard]] static NumberMember unless_last(I& ns, double unit_ns) noexcept {
    NumberMember member{ns, unit_ns};
    member.get_ = [](const void* from, double size) -> std::optional<double> {
      const I time = *static_cast<const I*>(from);
      return time == std::numeric_limits<I>::max() ? std::nullopt : std::optional{double(time) / size};
    };
    return member;
  }

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

/// What a number is unless it is given: a share of another one of its type. Both are bound by reference.
class NumberDefault {
 public:
  template <class T>
  NumberDefault(T& x, const T& by_default, double share = 1) noexcept
      : x_{&x}, from_{&by_default}, share_{share}, set_{[](void* to, const void* from, double of) {
          const T& value = *static_cast<const T*>(from);
          *static_cast<T*>(to) = of == 1.0 ? value : T(of * double(value));
        }} {}
  template <class T>
  NumberDefault(T& x, const T&& by_default, double share = 1) = delete;  // would be gone before it is read

  /// Sets the number.
  void set() const noexcept { set_(x_, from_, share_); }

 private:
  void* x_;
  const void* from_;
  double share_;
  void (*set_)(void*, const void*, double);
};

/// A text that may be set, whatever the type of string that holds it. The member is bound by reference.
class TextMember {
 public:
  template <class S>
    requires std::assignable_from<S&, std::string_view> && std::convertible_to<const S&, std::string_view>
  TextMember(S& x) noexcept  // NOLINT(google-explicit-constructor): stands for the member
      : x_{&x},
        get_{[](const void* from) -> std::string_view { return *static_cast<const S*>(from); }},
        set_{[](void* to, std::string_view value) { *static_cast<S*>(to) = value; }} {}

  [[nodiscard]] std::string_view get() const noexcept { return get_(x_); }
  void set(std::string_view value) const { set_(x_, value); }

 private:
  void* x_;
  std::string_view (*get_)(const void*);
  void (*set_)(void*, std::string_view);
};

/// A list of pairs of numbers that may be set, whatever the type of list and pair. The member is bound by
/// reference.
class PointsMember {
 public:
  using Point = std::pair<double, double>;

  /// The second number of each is in units of that size.
  template <class List>
    requires requires(List& list) { list.clear(); }
  PointsMember(List& list, double unit = 1) noexcept  // NOLINT(google-explicit-constructor): stands for it
      : x_{&list},
        unit_{unit},
        size_{[](const void* from) { return static_cast<const List*>(from)->size(); }},
        get_{[](const void* from, std::size_t k) {
          const auto& [first, second] = (*static_cast<const List*>(from))[k];
          return Point{first, second};
        }},
        set_{[](void* to, std::span<const Point> points, double size) {
          List& members = *static_cast<List*>(to);
          members.clear();
          for (const auto& [first, second] : points) members.push_back({first, second * size});
        }} {}

  [[nodiscard]] std::size_t size() const noexcept { return size_(x_); }
  [[nodiscard]] Point get(std::size_t k) const noexcept {
    const auto [first, second] = get_(x_, k);
    return {first, second / unit_};
  }
  void set(std::span<const Point> points) const { set_(x_, points, unit_); }

 private:
  void* x_;
  double unit_;
  std::size_t (*size_)(const void*);
  Point (*get_)(const void*, std::size_t);
  void (*set_)(void*, std::span<const Point>, double);
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
