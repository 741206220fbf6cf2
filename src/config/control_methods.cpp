#include "sextant/config/control_methods.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "bare_key.hpp"
#include "number_text.hpp"
#include "sextant/recording/trace_recorder.hpp"

namespace sextant {
namespace {

template <class... C>
ControlMethods methods_of(std::tuple<C...>* /*list*/) {
  return {control_method<C>()...};
}

bool is_shared_key(const std::string& name) {
  return name == "controller" || name == "flux_estimator" || name == "adapts_parameters" ||
         name == "flux_reference_wb" || name == "machine_estimate";
}

/// Each channel needs a dataset of its own in the group `control` of a trace.
void check_channels(const ControlMethod& method) {
  const std::vector<std::string> signals = trace_signals();
  std::set<std::string> taken{signals.begin(), signals.end()};
  for (const ControlChannel& channel : method.channels()) {
    const std::string name = channel.name;
    const bool is_name = !name.empty() && name.find('/') == std::string::npos;
    if (is_name && taken.insert("control/" + name).second) continue;
    std::string problem = "the channel \"" + name + "\" of the control method \"";
    problem += method.name();
    problem +=
        "\" needs another name, without \"/\", that no other channel of it and no column of the group "
        "control of a trace has";
    throw std::invalid_argument(problem);
  }
}

}  // namespace

std::string vector_step_problem(double current, double largest, std::int32_t period_ns) {
  if (!(current > largest)) return {};
  const auto rounded = [](double x) { return number_text(std::round(x * 10) / 10); };
  return "one voltage vector for one control period moves the current by " + rounded(current) +
         " A, more than " + rounded(largest) +
         " A, which stands for a third of the torque limit: drive.period_us may be " +
         rounded(std::floor(1e6 * (period_ns * 1e-9) * largest / current)) +
         " us at most with this method; others take shorter vectors";
}

ControlMethods control_methods() {
  ControlMethods methods = methods_of(static_cast<ControllerList<double>*>(nullptr));
  for (auto& method : methods_of(static_cast<CommissioningList<double>*>(nullptr)))
    methods.push_back(std::move(method));
  return methods;
}

ControlMethods with_own(ControlMethods methods, const ControlMethods& own) {
  for (const auto& method : own) {
    const std::string name = method->name();
    const bool taken =
        std::any_of(methods.begin(), methods.end(), [&name](const auto& m) { return m->name() == name; });
    if (taken || is_shared_key(name) || !is_bare_key(name)) {
      throw std::invalid_argument("the control method \"" + name +
                                  "\" needs another name, of letters, digits, _ and -, that no other method "
                                  "and no key of [control] has");
    }
    check_channels(*method);
    methods.push_back(method);
  }
  return methods;
}

ControlMethods untouched(const ControlMethods& methods) {
  ControlMethods fresh;
  fresh.reserve(methods.size());
  for (const auto& method : methods) fresh.emplace_back(method->untouched());
  return fresh;
}

}  // namespace sextant
