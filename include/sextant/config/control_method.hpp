#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "sextant/config/cloned.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/control/control_basis.hpp"
#include "sextant/control/controller.hpp"

namespace sextant {

/// What every control method shares with the drive, of which the `set_basis` of a method's `Parameters` takes
/// what it needs.
using ControlSetup = ControlBasis<double>;

template <class C>
class ControlMethodOf;

/// A control method as files choose and describe it: `control.controller = "NAME"` and the table
/// `[control.NAME]`. It holds the parameters of its controllers; `control_method` makes one of a controller's
/// class.
class ControlMethod {
 public:
  virtual ~ControlMethod() = default;

  /// Of the method and its table.
  [[nodiscard]] virtual const char* name() const noexcept = 0;
  /// One line for the reader of the file.
  [[nodiscard]] virtual const char* meaning() const noexcept = 0;
  /// What it adds to a trace.
  [[nodiscard]] virtual std::span<const ControlChannel> channels() const noexcept = 0;
  /// Describes the table. Parameters and `setup` are bound by reference.
  virtual void describe_table(Section table, const ControlSetup& setup) = 0;
  /// A controller with these parameters.
  [[nodiscard]] virtual std::unique_ptr<Controller<double>> make() const = 0;
  /// The same with the same parameters.
  [[nodiscard]] virtual std::unique_ptr<ControlMethod> clone() const = 0;
  /// The same with the parameters before a file has been read.
  [[nodiscard]] virtual std::unique_ptr<ControlMethod> untouched() const = 0;

  /// Parameters of the controllers of class `C`. Throws std::logic_error where the method is another.
  template <class C>
  [[nodiscard]] const typename C::Parameters& parameters() const {
    return parameters_of<const ControlMethodOf<C>>(*this);
  }
  template <class C>
  [[nodiscard]] typename C::Parameters& parameters() {
    return parameters_of<ControlMethodOf<C>>(*this);
  }

 protected:
  ControlMethod() = default;
  ControlMethod(const ControlMethod&) = default;
  ControlMethod& operator=(const ControlMethod&) = default;

 private:
  template <class Of, class Method>
  static auto& parameters_of(Method& method) {
    if (auto* const known = dynamic_cast<Of*>(&method)) return known->values;
    throw std::logic_error(std::string{"the control method \""} + method.name() +
                           "\" has no parameters of the class asked for");
  }
};

/// Empty where one voltage vector may move the current so far in a control period, else a sentence. [A], [ns]
[[nodiscard]] std::string vector_step_problem(double current, double largest, std::int32_t period_ns);

/// The method whose controllers are of class `C`, a `Controller<double>` with
///   static constexpr const char* name, meaning;   as above
///   static constexpr std::array channels{…};      of ControlChannel; may be left out
///   struct Parameters;                            defaults, validate(), set_basis(const ControlSetup&)
///   explicit C(const Parameters&);
/// and, found with the parameters, the keys of its table, as `Description` has it:
///   void describe(sextant::Description& d, C::Parameters& p, const C::Parameters& by_default);
/// by_default: the parameters that follow from the basis, which `set_defaults(const ControlSetup&)` sets
/// where Parameters has it. Ranges of keys are always checked; `validate()` is checked after all, for the
/// method chosen and for others of whose table a key is given. Where Parameters has `vector_step`, as that of
/// `DirectTorqueController`, what a vector changes in a control period is checked too.
template <class C>
class ControlMethodOf final : public ControlMethod {
 public:
  typename C::Parameters values{};

  [[nodiscard]] const char* name() const noexcept override { return C::name; }
  [[nodiscard]] const char* meaning() const noexcept override { return C::meaning; }
  [[nodiscard]] std::span<const ControlChannel> channels() const noexcept override {
    if constexpr (requires { C::channels; }) {
      static_assert(std::size(C::channels) <= control_channel_capacity);
      return C::channels;
    } else {
      return {};
    }
  }
  void describe_table(Section table, const ControlSetup& setup) override {
    table.derive([this, &setup] {
      values.set_basis(setup);
      by_default_.set_basis(setup);
      if constexpr (requires { by_default_.set_defaults(setup); }) by_default_.set_defaults(setup);
    });
    describe(table, values, std::as_const(by_default_));
    if constexpr (requires { C::Parameters::vector_step(setup); }) {
      table.check([&setup] {
        const auto [current, largest] = C::Parameters::vector_step(setup);
        return vector_step_problem(current, largest, setup.period_ns);
      });
    }
    table.check(values);
  }
  [[nodiscard]] std::unique_ptr<Controller<double>> make() const override {
    return std::make_unique<C>(values);
  }
  [[nodiscard]] std::unique_ptr<ControlMethod> clone() const override {
    return std::make_unique<ControlMethodOf>(*this);
  }
  [[nodiscard]] std::unique_ptr<ControlMethod> untouched() const override {
    return std::make_unique<ControlMethodOf>();
  }

 private:
  typename C::Parameters by_default_{};  ///< what follows from the basis
};

/// The methods that the configuration can select: Sextant's own and those that a program adds.
using ControlMethods = Parts<ControlMethod>;

/// The method whose controllers are of class `C`, with default parameters.
template <class C>
[[nodiscard]] Cloned<ControlMethod> control_method() {
  return Cloned<ControlMethod>{std::make_unique<ControlMethodOf<C>>()};
}

/// The list with `own` methods behind it. Throws std::invalid_argument where a name is no bare TOML key, is
/// taken or is that of another key of [control], and where a channel's name is empty, contains "/", is given
/// twice or is that of a column that every trace may have.
[[nodiscard]] ControlMethods with_own(ControlMethods methods, const ControlMethods& own);

}  // namespace sextant
