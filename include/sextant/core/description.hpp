#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/core/changes.hpp"
#include "sextant/core/described_number.hpp"

namespace sextant {

/// Name and value of one enumerator.
template <class E>
struct Choice {
  const char* name;
  E value;
};

/// What is said of a number beside its name.
struct Quantity {
  const char* unit;     ///< empty where there is none
  double min;           ///< least value allowed, included
  double max;           ///< largest value allowed, included
  const char* meaning;  ///< one line for a reader
  Changes changes{Changes::never};
};

/// The same of a time that is held in nanoseconds.
struct TimeQuantity {
  double unit_ns;  ///< length of the unit [ns]
  Quantity quantity;
};
[[nodiscard]] constexpr TimeQuantity in_us(double min, double max, const char* meaning,
                                           Changes changes = Changes::never) noexcept {
  return {1e3, {"us", min, max, meaning, changes}};
}
[[nodiscard]] constexpr TimeQuantity in_ms(double min, double max, const char* meaning,
                                           Changes changes = Changes::never) noexcept {
  return {1e6, {"ms", min, max, meaning, changes}};
}
[[nodiscard]] constexpr TimeQuantity in_s(double min, double max, const char* meaning,
                                          Changes changes = Changes::never) noexcept {
  return {1e9, {"s", min, max, meaning, changes}};
}

/// One of both numbers of a point.
struct Axis {
  const char* name;  ///< for messages
  double min;        ///< least value allowed, included
  double max;        ///< largest value allowed, included
};

/// Takes the members of a struct of parameters, one after the other, from the function `describe` that stands
/// beside the struct and binds all of them:
///
///   template <class T>
///   void describe(Description& d, Limits<T>& x) {
///     auto& [current, time_ns] = x;
///     d.number("current_a", current, {"A", 0.1, 1e5, "of a phase", Changes::always});
///     d.time("time_ms", time_ns, in_ms(1, 1e4, "for which it may be exceeded"));
///   }
///
/// A member that is added and not bound does not compile. A name is that of the key in a file, with the unit
/// behind it. A range is that of every drive; what depends on other values is a rule of the struct's
/// `validate()`. A member changes never while the drive runs unless it is described so. Members must outlive
/// the description. Not for the control path.
class Description {
 public:
  /// Why the default of a number may be missing, where nothing closer is known.
  static constexpr const char* no_usable_value = "no usable value follows from machine and link";

  virtual ~Description() = default;

  virtual void number(const char* name, NumberMember x, const Quantity& q) = 0;
  /// A number that follows from others unless it is given; `value` is the one in force.
  virtual void derived(const char* name, NumberMember given, NumberValue value, const Quantity& q) = 0;
  /// A number that is another one unless it is given. otherwise: why no usable one may follow.
  virtual void defaulted(const char* name, NumberMember x, NumberDefault by_default, const Quantity& q,
                         const char* otherwise) = 0;
  virtual void integer(const char* name, IntegerMember x, const char* unit, std::int64_t min,
                       std::int64_t max, const char* meaning, Changes changes) = 0;
  virtual void flag(const char* name, bool& x, const char* meaning, Changes changes) = 0;
  /// One of several names, each for a value of the member. The list need not outlive the call.
  virtual void choice(const char* name, IntegerMember x, std::span<const Choice<std::int64_t>> choices,
                      const char* meaning, Changes changes) = 0;
  /// A list of points; unit: as `Quantity` has it.
  virtual void points(const char* name, PointsMember x, const Axis& first, const Axis& second,
                      const char* unit, const char* meaning) = 0;
  virtual void text(const char* name, TextMember x, const char* meaning, bool may_be_empty) = 0;
  /// What follows until `leave` belongs to the table of that name within this one.
  virtual void enter(const char* table) = 0;
  virtual void leave() = 0;

  /// The number is held in the unit of the key; the default is found when everything has been read.
  template <std::floating_point T>
  void defaulted(const char* name, T& x, const T& by_default, const Quantity& q) {
    defaulted(name, x, {x, by_default}, q, no_usable_value);
  }
  void integer(const char* name, IntegerMember x, const char* unit, std::int64_t min, std::int64_t max,
               const char* meaning) {
    integer(name, x, unit, min, max, meaning, Changes::never);
  }
  void flag(const char* name, bool& x, const char* meaning) { flag(name, x, meaning, Changes::never); }

  template <std::signed_integral I>
  void time(const char* name, I& ns, const TimeQuantity& t) {
    number(name, {ns, t.unit_ns}, t.quantity);
  }
  template <std::signed_integral I>
  void defaulted_time(const char* name, I& ns, const I& by_default, const TimeQuantity& t) {
    defaulted(name, {ns, t.unit_ns}, {ns, by_default}, t.quantity, no_usable_value);
  }

  /// The same of an enumeration.
  template <class E, std::size_t N>
  void choice(const char* name, E& x, const Choice<E> (&choices)[N], const char* meaning,
              Changes changes = Changes::never) {
    std::array<Choice<std::int64_t>, N> values{};
    for (std::size_t k = 0; k < N; ++k) values[k] = {choices[k].name, std::int64_t(choices[k].value)};
    choice(name, IntegerMember{x}, values, meaning, changes);
  }

 protected:
  Description() = default;
  Description(const Description&) = default;
  Description& operator=(const Description&) = default;
};

}  // namespace sextant
