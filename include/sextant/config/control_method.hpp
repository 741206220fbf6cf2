#pragma once

#include <any>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sextant/config/schema.hpp"
#include "sextant/control/control_basis.hpp"
#include "sextant/control/controller.hpp"

namespace sextant {

/// What every control method shares with the drive, of which the `set_basis` of a method's `Parameters` takes
/// what it needs.
using ControlSetup = ControlBasis<double>;

/// A control method as files choose and describe it: `control.controller = "NAME"` and the table
/// `[control.NAME]`. `control_method` makes one of a controller's class.
struct ControlMethod {
  std::string name;                          ///< of the method and its table
  std::string meaning;                       ///< one line for the reader of the file
  std::span<const ControlChannel> channels;  ///< what it adds to a trace
  std::any parameters;                       ///< the controller's `Parameters`

  /// Describes the table. `parameters` and `setup` are bound by reference.
  void (*describe)(Section table, std::any& parameters, const ControlSetup& setup);
  /// A controller with these parameters.
  std::unique_ptr<Controller<double>> (*make)(const std::any& parameters);
  /// The parameters before a file has been read.
  std::any (*default_parameters)();
};

/// The channels of a controller's class, none where it declares none.
template <class C>
[[nodiscard]] constexpr std::span<const ControlChannel> channels_of() noexcept {
  if constexpr (requires { C::channels; }) {
    static_assert(std::size(C::channels) <= control_channel_capacity);
    return C::channels;
  } else {
    return {};
  }
}

/// The method whose controllers are of class `C`, a `Controller<double>` with
///   static constexpr const char* name, meaning;   as above
///   static constexpr std::array channels{…};      of ControlChannel; may be left out
///   struct Parameters;                            defaults, validate(), set_basis(const ControlSetup&)
///   explicit C(const Parameters&);
/// and, in the namespace of C, the keys of its table:
///   void describe(sextant::Section table, C::Parameters& p, const sextant::ControlSetup& setup);
/// `set_basis` runs before the rule of a `derived` key. Ranges of keys are always checked; `validate()` is
/// checked after all, for the method chosen and for others of whose table a key is given.
template <class C>
[[nodiscard]] ControlMethod control_method() {
  using Parameters = typename C::Parameters;
  return {.name = C::name,
          .meaning = C::meaning,
          .channels = channels_of<C>(),
          .parameters = Parameters{},
          .describe =
              [](Section table, std::any& parameters, const ControlSetup& setup) {
                auto& p = std::any_cast<Parameters&>(parameters);
                table.derive([&p, &setup] { p.set_basis(setup); });
                describe(table, p, setup);
                table.check(p);
              },
          .make = [](const std::any& parameters) -> std::unique_ptr<Controller<double>> {
            return std::make_unique<C>(std::any_cast<const Parameters&>(parameters));
          },
          .default_parameters = [] { return std::any{Parameters{}}; }};
}

/// The methods that the configuration can select: Sextant's own and those that a program adds.
using ControlMethods = std::vector<ControlMethod>;

/// The list with `own` methods behind it. Throws std::invalid_argument where a name is no bare TOML key, is
/// taken or is that of another key of [control], and where a channel's name is empty, contains "/", is given
/// twice or is that of a column that every trace may have.
[[nodiscard]] ControlMethods with_own(ControlMethods methods, std::span<const ControlMethod> own);

/// The same methods with their default parameters.
[[nodiscard]] ControlMethods untouched(ControlMethods methods);

}  // namespace sextant
