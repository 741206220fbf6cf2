#include "sextant/run/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

namespace sextant {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Zero times the sum is zero unless a value is NaN or infinite.
bool is_finite(const MetricsSample& s) noexcept {
  const double sum = (s.torque_reference + s.torque) + (s.psi_s.alpha + s.psi_s.beta) +
                     (s.i_s.alpha + s.i_s.beta) + s.omega_m;
  return 0 * sum == 0;
}

int turn_ons(SwitchState before, SwitchState now) noexcept {
  const unsigned on = now.upper_switches() & ~before.upper_switches();
  return int((on & 1U) + (on >> 1U & 1U) + (on >> 2U));
}

double line(double a, double b, double share) noexcept {
  return a + share * (b - a);
}

std::optional<LinkEnergies> line(const std::optional<LinkEnergies>& a, const std::optional<LinkEnergies>& b,
                                 double share) noexcept {
  if (!a || !b) return std::nullopt;
  return LinkEnergies{line(a->source, b->source, share), line(a->source_loss, b->source_loss, share),
                      line(a->chopper, b->chopper, share), line(a->stored, b->stored, share)};
}

std::optional<DrivelineEnergies> line(const std::optional<DrivelineEnergies>& a,
                                      const std::optional<DrivelineEnergies>& b, double share) noexcept {
  if (!a || !b) return std::nullopt;
  return DrivelineEnergies{line(a->friction, b->friction, share), line(a->damping, b->damping, share),
                           line(a->load, b->load, share), line(a->kinetic, b->kinetic, share),
                           line(a->elastic, b->elastic, share)};
}

std::optional<InverterEnergies> line(const std::optional<InverterEnergies>& a,
                                     const std::optional<InverterEnergies>& b, double share) noexcept {
  if (!a || !b) return std::nullopt;
  return InverterEnergies{line(a->lost, b->lost, share), line(a->drawn, b->drawn, share)};
}

DriveEnergies line(const DriveEnergies& a, const DriveEnergies& b, double share) noexcept {
  return {line(a.link, b.link, share),
          line(a.copper, b.copper, share),
          line(a.shaft, b.shaft, share),
          line(a.field, b.field, share),
          line(a.iron, b.iron, share),
          line(a.before_link, b.before_link, share),
          line(a.behind_shaft, b.behind_shaft, share),
          line(a.inverter, b.inverter, share)};
}

void fill(MetricList& m, const LinkEnergies& before_link) noexcept {
  m[Metric::energy_source] = before_link.source;
  m[Metric::energy_source_loss] = before_link.source_loss;
  m[Metric::energy_chopper] = before_link.chopper;
  m[Metric::energy_stored] = before_link.stored;
}

void fill(MetricList& m, const ThermalNodes<double>& hottest) noexcept {
  m[Metric::winding_temperature] = hottest.winding;
  m[Metric::rotor_temperature] = hottest.rotor;
  m[Metric::housing_temperature] = hottest.housing;
}

void fill(MetricList& m, const DrivelineEnergies& behind_shaft) noexcept {
  m[Metric::energy_friction] = behind_shaft.friction;
  m[Metric::energy_damping] = behind_shaft.damping;
  m[Metric::energy_load] = behind_shaft.load;
  m[Metric::energy_kinetic] = behind_shaft.kinetic;
  m[Metric::energy_elastic] = behind_shaft.elastic;
}

void fill(MetricList& m, const TorqueDeviation& deviation) noexcept {
  m[Metric::torque_deviation] = deviation.largest();
  m[Metric::torque_silent] = deviation.longest_ms();
  m[Metric::torque_motoring] = deviation.motoring();
  m[Metric::torque_regenerating] = deviation.regenerating();
}

}  // namespace

MetricsAccumulator::MetricsAccumulator(const MetricsParameters& parameters)
    : parameters_{parameters}, response_{parameters.step_ns} {
  if (const char* wrong = parameters.validate()) throw std::runtime_error{std::string{"metrics: "} + wrong};
}

void MetricsAccumulator::add_segment(const MetricsSample& before, const MetricsSample& after) noexcept {
  any_ = true;
  finite_ = finite_ && is_finite(before) && is_finite(after);
  if (!finite_) return;
  note_current(before.i_s);
  note_current(after.i_s);
  note_reference(before, after);
  const double begin_ns = before.since(parameters_.from_ns);
  const double duration_ns = double(after.t_ns - before.t_ns) + (after.fraction_ns - before.fraction_ns);
  if (duration_ns <= 0) return;
  const double seconds = duration_ns * 1e-9;
  const EnergyFlow flow =
      EnergyFlow::between(before.energies, after.energies, before.p_dc, after.p_dc, seconds);
  balance_.add(flow);
  if (response_.watching()) response_.add_segment(before, after);
  if (deviation_) deviation_->add_segment(before.torque, after.torque, duration_ns);
  if (begin_ns + duration_ns <= 0 || before.t_ns >= parameters_.to_ns) return;
  WindowPiece piece{window_values(before), window_values(after), flow, seconds};
  if (begin_ns < 0 || after.t_ns >= parameters_.to_ns) [[unlikely]]
    cut_to_window(piece, before, after);
  add_to_window(piece);
}

void MetricsAccumulator::commutate(std::int64_t t_ns, SwitchState state) noexcept {
  if (switch_state_ == state) return;
  // An edge on the window's first instant belongs to the time before it.
  if (switch_state_ && t_ns > parameters_.from_ns && t_ns <= parameters_.to_ns)
    turn_ons_ += turn_ons(*switch_state_, state);
  switch_state_ = state;
}

void MetricsAccumulator::note_temperatures(std::int64_t t_ns,
                                           const ThermalNodes<double>& temperatures) noexcept {
  if (std::isnan(temperatures.winding) || t_ns < parameters_.from_ns || t_ns > parameters_.to_ns) return;
  ThermalNodes<double>& most = hottest_ ? *hottest_ : hottest_.emplace(temperatures);
  most = {std::max(most.winding, temperatures.winding), std::max(most.rotor, temperatures.rotor),
          std::max(most.housing, temperatures.housing)};
}

void MetricsAccumulator::note_inverter(std::int64_t t_ns, double junction, double device_case) noexcept {
  if (t_ns < parameters_.from_ns || t_ns > parameters_.to_ns) return;
  InverterHeat& most =
      hottest_inverter_ ? *hottest_inverter_ : hottest_inverter_.emplace(junction, device_case);
  most = {std::max(most.junction, junction), std::max(most.device_case, device_case)};
}

void MetricsAccumulator::pulse(std::int64_t t_ns, std::int64_t count) noexcept {
  if (t_ns > parameters_.from_ns && t_ns <= parameters_.to_ns) pulses_ += count;
}

void MetricsAccumulator::has_control_period(std::int64_t period_ns) {
  deviation_.emplace(period_ns, parameters_.from_ns, parameters_.to_ns, parameters_.torque_tolerance);
}

void MetricsAccumulator::note_reference(const MetricsSample& before, const MetricsSample& after) noexcept {
  constexpr double rounding_nm = 1e-6;
  if (before.t_ns >= parameters_.to_ns) return;
  if (after.t_ns <= parameters_.from_ns - settling_ns) {
    reference_ = after.torque_reference;
  } else if (std::abs(before.torque_reference - reference_) > rounding_nm ||
             std::abs(after.torque_reference - reference_) > rounding_nm) {
    steady_ = false;
  }
}

const MetricsAccumulator::FluxFrame& MetricsAccumulator::flux_frame(const MetricsSample& s) noexcept {
  if (s.psi_s == frame_.psi_s && s.i_s == frame_.i_s) return frame_;
  const double psi = magnitude(s.psi_s);
  // A machine without flux has no flux angle; phase a's axis replaces it.
  const SpaceVector<> axis = psi > 0 ? (1 / psi) * s.psi_s : SpaceVector<>{1, 0};
  frame_ = {s.psi_s, s.i_s, psi, dot(axis, s.i_s), cross(axis, s.i_s)};
  return frame_;
}

MetricsAccumulator::WindowValues MetricsAccumulator::window_values(const MetricsSample& s) noexcept {
  const FluxFrame& frame = flux_frame(s);
  return {{s.torque - s.torque_reference, frame.flux, frame.i_flux, frame.i_quadrature},
          s.omega_m - s.speed_reference,
          s.load};
}

void MetricsAccumulator::cut_to_window(WindowPiece& piece, const MetricsSample& before,
                                       const MetricsSample& after) const noexcept {
  const double duration_ns = double(after.t_ns - before.t_ns) + (after.fraction_ns - before.fraction_ns);
  const double begin = std::max(0.0, -before.since(parameters_.from_ns) / duration_ns);
  const double end = std::min(1.0, -before.since(parameters_.to_ns) / duration_ns);
  const auto at = [&a = piece.begin, &b = piece.end](double share) -> WindowValues {
    WindowValues cut{a.values + share * (b.values - a.values), line(a.speed_error, b.speed_error, share), {}};
    if (a.load && b.load) cut.load = LoadSample::between(*a.load, *b.load, share);
    return cut;
  };
  const double seconds = (end - begin) * duration_ns * 1e-9;
  const EnergyFlow flow = EnergyFlow::between(
      line(before.energies, after.energies, begin), line(before.energies, after.energies, end),
      line(before.p_dc, after.p_dc, begin), line(before.p_dc, after.p_dc, end), seconds);
  piece = {at(begin), at(end), flow, seconds};
}

void MetricsAccumulator::note_current(SpaceVector<> i_s) noexcept {
  // No phase current exceeds the vector.
  if (dot(i_s, i_s) <= peak_current_ * peak_current_) return;
  const ThreePhase<> i = inverse_clarke(i_s);
  peak_current_ = std::max({peak_current_, std::abs(i.a), std::abs(i.b), std::abs(i.c)});
}

void MetricsAccumulator::add_to_window(const WindowPiece& piece) noexcept {
  const auto& [begin, end, flow, seconds] = piece;
  moments_.add_line(begin.values, end.values, seconds);
  const Moments<quantities>::Values current = 0.5 * (begin.values + end.values);
  current_.add({current[i_flux], current[i_quadrature]}, seconds);
  if (switch_state_ && !is_driven(*switch_state_)) steady_ = false;
  energy_.add(flow);
  const double x = begin.speed_error;
  const double y = end.speed_error;
  speed_error_squares_ += seconds * ((x * x + x * y + y * y) * (1.0 / 3));
  if (begin.load) note_load(*begin.load);
  if (end.load) note_load(*end.load);
}

void MetricsAccumulator::note_load(const LoadSample& load) noexcept {
  const LoadRange before = load_ ? *load_ : LoadRange{load, load};
  load_ = {.least = {std::min(before.least.shaft_torque, load.shaft_torque),
                     std::min(before.least.speed, load.speed)},
           .largest = {std::max(before.largest.shaft_torque, load.shaft_torque),
                       std::max(before.largest.speed, load.speed)}};
}

MetricList MetricsAccumulator::metrics() const noexcept {
  MetricList m;
  if (!any_ || !finite_) return m;
  m[Metric::peak_current] = peak_current_;
  m[Metric::response_time] = response_.time_ms().value_or(nan);
  m[Metric::energy_unaccounted] = balance_.unaccounted();
  if (deviation_) fill(m, *deviation_);
  if (hottest_) fill(m, *hottest_);
  if (hottest_inverter_) {
    m[Metric::junction_temperature] = hottest_inverter_->junction;
    m[Metric::case_temperature] = hottest_inverter_->device_case;
  }
  if (moments_.weight() > 0) fill_window_metrics(m);
  return m;
}

void MetricsAccumulator::fill_window_metrics(MetricList& m) const noexcept {
  const auto mean = moments_.mean();
  const auto variance = moments_.variance();
  const auto& min = moments_.min();
  const auto& max = moments_.max();
  m[Metric::torque_ripple_pp] = max[torque_error] - min[torque_error];
  m[Metric::torque_ripple_rms] = std::sqrt(variance[torque_error]);
  m[Metric::torque_bias] = mean[torque_error];
  m[Metric::torque_error_rms] = std::hypot(mean[torque_error], m[Metric::torque_ripple_rms]);
  m[Metric::torque_error_max] = std::max(max[torque_error], -min[torque_error]);
  m[Metric::flux_mean] = mean[flux];
  m[Metric::flux_min] = min[flux];
  m[Metric::flux_max] = max[flux];
  const SpaceVector<> fundamental{mean[i_flux], mean[i_quadrature]};
  const double harmonics = std::sqrt(variance[i_flux] + variance[i_quadrature]);
  const bool lasts = steady_ && magnitude(fundamental) > 0 && current_.agrees_with(fundamental);
  m[Metric::current_thd] = lasts ? 100 * harmonics / magnitude(fundamental) : nan;
  m[Metric::speed_error_rms] = std::sqrt(speed_error_squares_ / moments_.weight());
  const double seconds = moments_.weight();
  constexpr double legs = 3;
  m[Metric::switching_frequency] = double(turn_ons_) / legs / seconds;
  m[Metric::torque_pulse_frequency] = has_pulses_ ? double(pulses_) / seconds : nan;
  m[Metric::energy_from_link] = energy_.from_link();
  m[Metric::energy_to_link] = energy_.to_link();
  m[Metric::energy_shaft] = energy_.shaft();
  m[Metric::energy_copper] = energy_.copper();
  m[Metric::energy_iron] = energy_.iron();
  m[Metric::energy_field] = energy_.field();
  if (energy_.before_link()) fill(m, *energy_.before_link());
  if (energy_.behind_shaft()) fill(m, *energy_.behind_shaft());
  fill_inverter_metrics(m);
  if (!load_) return;
  m[Metric::shaft_torque_min] = load_->least.shaft_torque;
  m[Metric::shaft_torque_max] = load_->largest.shaft_torque;
  m[Metric::load_speed_min] = load_->least.speed;
  m[Metric::load_speed_max] = load_->largest.speed;
}

void MetricsAccumulator::fill_inverter_metrics(MetricList& m) const noexcept {
  if (!energy_.inverter()) return;
  const auto& [lost, drawn] = *energy_.inverter();
  m[Metric::energy_inverter] = drawn;
  m[Metric::inverter_loss] = lost / moments_.weight();
  // Link and machine feed the inverter, each where it gives energy; neither gets any where both do.
  const double from_link = energy_.net_link();
  const double from_machine = lost - from_link;
  const double in = std::max(from_link, 0.0) + std::max(from_machine, 0.0);
  m[Metric::inverter_efficiency] = in > 0 ? 1 - lost / in : nan;
}

}  // namespace sextant
