#include "sextant/recording/trace_recorder.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "sextant/recording/trace_divider.hpp"
#include "sextant/recording/trace_reducer.hpp"
#include "trace_columns.hpp"
#include "trace_file.hpp"

namespace sextant {
namespace {

void print_error(const std::string& error) {
  std::fprintf(stderr, "%s\n", error.c_str());
}

std::int64_t interval_ns(const TraceParameters& parameters) {
  if (const char* wrong = parameters.validate()) throw std::runtime_error{wrong};
  const std::int64_t ns = std::llround(parameters.interval_us * 1e3);
  if (ns < 1) throw std::runtime_error{"the trace interval must be at least 1 ns"};
  return ns;
}

std::vector<std::string> known(std::vector<std::string> signals, std::span<const ControlChannel> channels) {
  const std::vector<std::string> names = trace_signals(channels);
  for (const std::string& signal : signals) {
    if (std::find(names.begin(), names.end(), signal) == names.end())
      throw std::runtime_error{fmt::format("there is no trace signal \"{}\"", signal)};
  }
  return signals;
}

/// How often the shorter of interval and control period is in the longer one.
std::uint32_t whole_ratio(std::int64_t interval_ns, std::int64_t control_period_ns) {
  if (control_period_ns <= 0) throw std::runtime_error{"the control period must be above zero"};
  const auto [shorter, longer] = std::minmax(interval_ns, control_period_ns);
  if (longer % shorter != 0 || longer / shorter > std::numeric_limits<std::uint32_t>::max()) {
    throw std::runtime_error{fmt::format(
        "the trace interval of {} us is not a whole number of control periods of {} us, nor a whole "
        "part of one",
        double(interval_ns) * 1e-3, double(control_period_ns) * 1e-3)};
  }
  return static_cast<std::uint32_t>(longer / shorter);
}

std::optional<TraceReducer> make_reducer(std::int64_t interval_ns, const TraceOrigin& origin) {
  if (!origin.control_period_ns) return std::nullopt;
  const std::uint32_t ratio = whole_ratio(interval_ns, *origin.control_period_ns);
  return TraceReducer{interval_ns < *origin.control_period_ns ? 1 : ratio};
}

std::optional<TraceDivider> make_divider(std::int64_t interval_ns, const TraceOrigin& origin) {
  if (!origin.control_period_ns || interval_ns >= *origin.control_period_ns) return std::nullopt;
  return TraceDivider{whole_ratio(interval_ns, *origin.control_period_ns), interval_ns};
}

}  // namespace

std::vector<std::string> trace_groups() {
  std::vector<std::string> names{"all"};
  for (const TraceColumn& c : trace_columns) {
    if (std::find(names.begin(), names.end(), c.group) == names.end()) names.emplace_back(c.group);
  }
  return names;
}

std::vector<std::string> trace_signals(std::span<const ControlChannel> channels) {
  std::vector<std::string> names = trace_groups();
  for (const TraceColumn& c : trace_columns) names.push_back(c.path());
  for (const TraceColumn& c : channel_columns(channels)) names.push_back(c.path());
  return names;
}

class TraceRecorder::Impl {
 public:
  Impl(const std::filesystem::path& file, const TraceParameters& parameters, const TraceOrigin& origin,
       ErrorHandler on_error)
      : reducer_{make_reducer(interval_ns(parameters), origin)},
        divider_{make_divider(interval_ns(parameters), origin)},
        file_{file,
              {.scenario = origin.scenario,
               .control_period_ns = origin.control_period_ns,
               .interval_ns = interval_ns(parameters),
               .begin_ns = origin.begin_ns,
               .compression = parameters.compression,
               .plant = origin.plant,
               .channels = origin.channels,
               .signals = known(parameters.signals, origin.channels)},
              on_error ? std::move(on_error) : print_error} {}

  ~Impl() { close(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void add_segment(const PlantSample& before, const PlantSample& after, double seconds) {
    if (divider_)
      divider_->add_segment(before, after, seconds, [this](const TraceRow& row) { file_.append(row); });
    else
      reducer().add_segment(before, after, seconds);
  }

  void add(const Telemetry<>& telemetry, const PlantSample& plant, const ControlSample& control) {
    TraceReducer& rows = reducer();
    if (divider_)
      file_.append(divider_->add(telemetry, plant, control));
    else if (rows.add(telemetry, plant, control))
      file_.append(rows.take());
  }

  void add_row(const TraceRow& row) { file_.append(row); }

  void flush() { file_.flush(); }

  void close() {
    if (reducer_ && !reducer_->empty()) file_.append(reducer_->take());
    file_.close();
  }

  [[nodiscard]] const std::string& error() const noexcept { return file_.error(); }

 private:
  TraceReducer& reducer() {
    if (!reducer_) throw std::logic_error{"an event-exact run has no control periods to record"};
    return *reducer_;
  }

  std::optional<TraceReducer> reducer_;  // none in an event-exact run
  std::optional<TraceDivider> divider_;  // of several rows a control period
  TraceFile file_;
};

TraceRecorder::TraceRecorder(const std::filesystem::path& file, const TraceParameters& parameters,
                             const TraceOrigin& origin, ErrorHandler on_error) {
  try {
    impl_ = std::make_unique<Impl>(file, parameters, origin, std::move(on_error));
  } catch (const std::runtime_error& e) {
    throw std::runtime_error{fmt::format("{}: cannot record a trace: {}", file.string(), e.what())};
  }
}

TraceRecorder::~TraceRecorder() = default;
TraceRecorder::TraceRecorder(TraceRecorder&&) noexcept = default;
TraceRecorder& TraceRecorder::operator=(TraceRecorder&&) noexcept = default;

void TraceRecorder::add_segment(const PlantSample& before, const PlantSample& after, double seconds) {
  impl_->add_segment(before, after, seconds);
}
void TraceRecorder::add(const Telemetry<>& telemetry, const PlantSample& plant,
                        const ControlSample& control) {
  impl_->add(telemetry, plant, control);
}
void TraceRecorder::add_row(const TraceRow& row) {
  impl_->add_row(row);
}
void TraceRecorder::flush() {
  impl_->flush();
}
void TraceRecorder::close() {
  impl_->close();
}
const std::string& TraceRecorder::error() const noexcept {
  return impl_->error();
}

}  // namespace sextant
