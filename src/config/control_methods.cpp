#include "sextant/config/control_methods.hpp"

#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "drive_sections.hpp"
#include "number_text.hpp"
#include "own_names.hpp"
#include "sextant/recording/trace_recorder.hpp"

namespace sextant {
namespace {

template <class... C>
ControlMethods methods_of(std::tuple<C...>* /*list*/) {
  return {control_method<C>()...};
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
  if (own.empty()) return methods;
  DriveConfig config;
  config.methods.clear();
  Schema schema;
  describe_control(Section{schema}, config);
  std::vector<std::string> taken = names_in(schema, "");
  for (const auto& method : methods) taken.emplace_back(method->name());
  for (const auto& method : own) {
    take_name(taken, method->name(), "control method", "no other method and no key of [control]");
    check_channels(*method);
    methods.push_back(method);
  }
  return methods;
}

}  // namespace sextant
