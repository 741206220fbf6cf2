#include "sextant/sim/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace sextant {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double response_share = 0.95;

bool is_finite(const MetricsSample& s) noexcept {
  return std::isfinite(s.torque_reference) && std::isfinite(s.torque) && std::isfinite(s.psi_s.alpha) &&
         std::isfinite(s.psi_s.beta) && std::isfinite(s.i_s.alpha) && std::isfinite(s.i_s.beta) &&
         std::isfinite(s.omega_m);
}

int turn_ons(LegState before, LegState now) noexcept {
  return int(before != LegState::high && now == LegState::high);
}

}  // namespace

void MetricsAccumulator::RunningMean::add(double x, double weight) noexcept {
  const double deviation = x - mean;
  mean += weight * deviation;
  sum_of_squares += deviation * (x - mean);
  min = std::min(min, x);
  max = std::max(max, x);
}

MetricsAccumulator::MetricsAccumulator(const MetricsParameters& parameters) : parameters_{parameters} {
  if (const char* wrong = parameters.validate()) throw std::runtime_error{std::string{"metrics: "} + wrong};
}

void MetricsAccumulator::add(const MetricsSample& sample) noexcept {
  any_ = true;
  if (!is_finite(sample)) finite_ = false;
  if (!finite_) return;
  const ThreePhase<> i = inverse_clarke(sample.i_s);
  peak_current_ = std::max({peak_current_, std::abs(i.a), std::abs(i.b), std::abs(i.c)});
  commutate(sample.t_ns, sample.switch_state);
  if (sample.t_ns >= parameters_.from_ns && sample.t_ns <= parameters_.to_ns) add_to_window(sample);
  watch_step(sample);
}

void MetricsAccumulator::commutate(std::int64_t t_ns, SwitchState state) noexcept {
  // An edge on the window's first sample belongs to the time before it.
  if (switch_state_ && samples_ > 0 && t_ns <= parameters_.to_ns) {
    turn_ons_ += turn_ons(switch_state_->a(), state.a()) + turn_ons(switch_state_->b(), state.b()) +
                 turn_ons(switch_state_->c(), state.c());
  }
  switch_state_ = state;
}

void MetricsAccumulator::add_to_window(const MetricsSample& sample) noexcept {
  if (samples_++ == 0) first_ns_ = sample.t_ns;
  last_ns_ = sample.t_ns;
  const double weight = 1 / double(samples_);
  const double psi = magnitude(sample.psi_s);
  // A machine without flux has no flux angle; phase a's axis stands in for it.
  const SpaceVector<> axis = psi > 0 ? (1 / psi) * sample.psi_s : SpaceVector<>{1, 0};
  torque_error_.add(sample.torque - sample.torque_reference, weight);
  flux_.add(psi, weight);
  i_flux_.add(dot(axis, sample.i_s), weight);
  i_quadrature_.add(cross(axis, sample.i_s), weight);
}

void MetricsAccumulator::watch_step(const MetricsSample& sample) noexcept {
  if (!parameters_.step_ns || response_ms_) return;
  if (sample.t_ns < *parameters_.step_ns) {
    reference_before_ = sample.torque_reference;
    return;
  }
  if (!reference_after_) reference_after_ = sample.torque_reference;
  const double step = *reference_after_ - reference_before_;
  if (step != 0 && (sample.torque - reference_before_) / step >= response_share) {
    response_ms_ = double(sample.t_ns - *parameters_.step_ns) * 1e-6;
  }
}

double MetricsAccumulator::switching_frequency() const noexcept {
  if (last_ns_ <= first_ns_) return nan;
  constexpr double legs = 3;
  return double(turn_ons_) / legs / (double(last_ns_ - first_ns_) * 1e-9);
}

MetricList MetricsAccumulator::metrics() const noexcept {
  MetricList m;
  if (!any_ || !finite_) return m;
  m[Metric::peak_current] = peak_current_;
  m[Metric::response_time] = response_ms_.value_or(nan);
  if (samples_ == 0) return m;
  const auto n = double(samples_);
  m[Metric::torque_ripple_pp] = torque_error_.max - torque_error_.min;
  m[Metric::torque_ripple_rms] = std::sqrt(torque_error_.sum_of_squares / n);
  m[Metric::torque_bias] = torque_error_.mean;
  m[Metric::flux_mean] = flux_.mean;
  m[Metric::flux_min] = flux_.min;
  m[Metric::flux_max] = flux_.max;
  m[Metric::switching_frequency] = switching_frequency();
  const double fundamental = std::hypot(i_flux_.mean, i_quadrature_.mean);
  const double harmonics = std::sqrt((i_flux_.sum_of_squares + i_quadrature_.sum_of_squares) / n);
  m[Metric::current_thd] = fundamental > 0 ? 100 * harmonics / fundamental : nan;
  return m;
}

}  // namespace sextant
