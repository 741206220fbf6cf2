#pragma once

#include <concepts>
#include <cstddef>
#include <span>
#include <utility>

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/appended_system.hpp"

namespace sextant {

/// Two appended systems as one; the states of the second follow those of the first. It feeds back what either
/// of them does, the first before the second; events of the second follow those of the first.
template <class First, class Second, class T = double>
  requires AppendedSystem<First, T> && AppendedSystem<Second, T>
struct AppendedPair {
  static constexpr int size = First::size + Second::size;
  static constexpr bool is_integral = sextant::is_integral<First> && sextant::is_integral<Second>;
  static constexpr bool last_is_uncontrolled = sextant::last_is_uncontrolled<Second>;
  static constexpr bool feeds_back = sextant::feeds_back<First> || sextant::feeds_back<Second>;
  static constexpr bool keeps_link_voltage = !moves_link_voltage<First> && !moves_link_voltage<Second>;
  static constexpr int event_count = appended_event_count<First> + appended_event_count<Second>;
  static constexpr int second_begin = First::size;  ///< index of the second system's first state

  First first;
  Second second;

  constexpr AppendedPair(First a, Second b) noexcept : first{std::move(a)}, second{std::move(b)} {}

  /// Both derivatives, in the units of each.
  constexpr void derivative(const PlantQuantities<T>& plant, std::span<const T, std::size_t(size)> y,
                            std::span<T, std::size_t(size)> dy) const noexcept SEXTANT_NONBLOCKING {
    first.derivative(plant, y.template first<head>(), dy.template first<head>());
    second.derivative(plant, y.template last<tail>(), dy.template last<tail>());
  }

  // The rest is as `FeedbackSystem` has it.
  constexpr void begin(std::span<T, std::size_t(size)> y, T omega_m) const noexcept SEXTANT_NONBLOCKING {
    if constexpr (sextant::feeds_back<First>) first.begin(y.template first<head>(), omega_m);
    if constexpr (sextant::feeds_back<Second>) second.begin(y.template last<tail>(), omega_m);
  }
  constexpr void act(std::span<const T, std::size_t(size)> y, T omega_m,
                     PlantInputs<T>& inputs) const noexcept SEXTANT_NONBLOCKING {
    if constexpr (sextant::feeds_back<First>) first.act(y.template first<head>(), omega_m, inputs);
    if constexpr (sextant::feeds_back<Second>) second.act(y.template last<tail>(), omega_m, inputs);
  }
  constexpr void events(std::span<const T, std::size_t(size)> y, T omega_m, const PlantInputs<T>& given,
                        std::span<T, std::size_t(event_count)> g) const noexcept SEXTANT_NONBLOCKING {
    if constexpr (sextant::feeds_back<First>)
      first.events(y.template first<head>(), omega_m, given, g.template first<head_events>());
    if constexpr (sextant::feeds_back<Second>)
      second.events(y.template last<tail>(), omega_m, given, g.template last<tail_events>());
  }
  constexpr void on_event(int event, std::span<T, std::size_t(size)> y) noexcept SEXTANT_NONBLOCKING {
    if constexpr (sextant::feeds_back<First>) {
      if (event < int(head_events)) return first.on_event(event, y.template first<head>());
    }
    if constexpr (sextant::feeds_back<Second>)
      second.on_event(event - int(head_events), y.template last<tail>());
  }
  constexpr bool settle(std::span<T, std::size_t(size)> y, T omega_m,
                        const PlantInputs<T>& given) noexcept SEXTANT_NONBLOCKING {
    bool changed = false;
    if constexpr (sextant::feeds_back<First>)
      changed = first.settle(y.template first<head>(), omega_m, given);
    if constexpr (sextant::feeds_back<Second>)
      changed = second.settle(y.template last<tail>(), omega_m, given) || changed;
    return changed;
  }
  [[nodiscard]] constexpr T rate_squared() const noexcept SEXTANT_NONBLOCKING {
    T sum{};
    if constexpr (sextant::feeds_back<First>) sum += first.rate_squared();
    if constexpr (sextant::feeds_back<Second>) sum += second.rate_squared();
    return sum;
  }
  [[nodiscard]] constexpr bool is_valid(std::span<const T, std::size_t(size)> y) const noexcept
      SEXTANT_NONBLOCKING {
    bool valid = true;
    if constexpr (sextant::feeds_back<First>) valid = first.is_valid(y.template first<head>());
    if constexpr (sextant::feeds_back<Second>) valid = valid && second.is_valid(y.template last<tail>());
    return valid;
  }

 private:
  static constexpr auto head = std::size_t(First::size);
  static constexpr auto tail = std::size_t(Second::size);
  static constexpr auto head_events = std::size_t(appended_event_count<First>);
  static constexpr auto tail_events = std::size_t(appended_event_count<Second>);
};

/// True where a system is an appended one, or part of it.
template <class Part, class Whole>
inline constexpr bool has_part = std::same_as<Part, Whole>;
template <class Part, class First, class Second, class T>
inline constexpr bool has_part<Part, AppendedPair<First, Second, T>> =
    has_part<Part, First> || has_part<Part, Second>;

/// A temporary's part would outlive it.
template <class Part, class Whole>
  requires has_part<Part, Whole>
const Part& part_of(const Whole&&) = delete;
/// The part of an appended system.
template <class Part, class Whole>
  requires has_part<Part, Whole>
[[nodiscard]] constexpr const Part& part_of(const Whole& whole) noexcept SEXTANT_NONBLOCKING {
  if constexpr (std::same_as<Part, Whole>)
    return static_cast<const Part&>(whole);
  else if constexpr (has_part<Part, decltype(Whole::first)>)
    return part_of<Part>(whole.first);
  else
    return part_of<Part>(whole.second);
}

/// Index of the part's first state among those of the appended system. [-]
template <class Part, class Whole>
  requires has_part<Part, Whole>
[[nodiscard]] consteval int part_begin() noexcept {
  if constexpr (std::same_as<Part, Whole>)
    return 0;
  else if constexpr (has_part<Part, decltype(Whole::first)>)
    return part_begin<Part, decltype(Whole::first)>();
  else
    return Whole::second_begin + part_begin<Part, decltype(Whole::second)>();
}

}  // namespace sextant
