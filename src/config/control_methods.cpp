#include "sextant/config/control_methods.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace sextant {
namespace {

template <class... C>
ControlMethods methods_of(std::tuple<C...>* /*list*/) {
  return {control_method<C>()...};
}

bool is_bare_key(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

bool is_shared_key(const std::string& name) {
  return name == "controller" || name == "flux_reference_wb" || name == "machine_estimate";
}

}  // namespace

ControlMethods control_methods() {
  return methods_of(static_cast<ControllerList<double>*>(nullptr));
}

ControlMethods with_own(ControlMethods methods, std::span<const ControlMethod> own) {
  for (const ControlMethod& method : own) {
    const bool taken = std::any_of(methods.begin(), methods.end(),
                                   [&method](const ControlMethod& m) { return m.name == method.name; });
    if (taken || is_shared_key(method.name) || !is_bare_key(method.name)) {
      throw std::invalid_argument("the control method \"" + method.name +
                                  "\" needs another name, of letters, digits, _ and -, that no other method "
                                  "and no key of [control] has");
    }
    methods.push_back(method);
  }
  return methods;
}

ControlMethods untouched(ControlMethods methods) {
  for (ControlMethod& method : methods) method.parameters = method.default_parameters();
  return methods;
}

}  // namespace sextant
