#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sextant/event_exact/event_exact_system.hpp"
#include "sextant/recording/plant_envelope.hpp"
#include "sextant/recording/trace_recorder.hpp"
#include "sextant/run/plant_look.hpp"

namespace sextant {

/// Reduces the pieces of an event-exact run to the rows of a trace: between two rows the envelope of all
/// instants at which something switched, so that no peak is lost.
class EventExactTrace {
 public:
  /// The recorder is not owned.
  EventExactTrace(TraceRecorder& recorder, double interval_us) noexcept
      : recorder_{recorder}, interval_ns_{std::llround(interval_us * 1e3)} {}

  /// End of the row that t_ns lies in. [ns]
  [[nodiscard]] std::int64_t row_end_ns(std::int64_t t_ns) const noexcept {
    return (t_ns / interval_ns_ + 1) * interval_ns_;
  }

  /// A stretch begins or something has switched: what follows starts from here.
  void begin(const EventExactSystem& system, double tau_l) noexcept {
    tau_l_ = tau_l;
    before_ = look(system);
  }

  /// A piece of that duration [s] has ended.
  void add(const EventExactSystem& system, double duration) noexcept {
    const Look after = look(system);
    plant_.add_segment(before_.plant, after.plant, duration);
    torque_.add(before_.torque, after.torque, duration);
    flux_.add(before_.flux, after.flux, duration);
    current_.add(before_.current, after.current, duration);
    link_.add(before_.plant.i_dc, after.plant.i_dc, duration);
    before_ = after;
  }

  /// Writes the row that ends at t_ns.
  void finish_row(std::int64_t t_ns, const EventExactSystem& system) {
    const SpaceVector<> estimate = system.estimated_flux();
    TraceRow row;
    row.plant = plant_.row(before_.plant);
    row.control = {std::int8_t(system.comparators().torque_demand()),
                   std::int8_t(system.comparators().flux_demand() ? 1 : 0)};
    row.drive = {.t_ns = t_ns,
                 .torque_requested_nm = system.reference(),
                 .torque_reference_nm = system.reference(),
                 .torque_mean_nm = torque_.mean(),
                 .torque_min_nm = torque_.min,
                 .torque_max_nm = torque_.max,
                 .flux_mean_wb = flux_.mean(),
                 .flux_min_wb = flux_.min,
                 .flux_max_wb = flux_.max,
                 .current_mean_a = current_.mean(),
                 .current_min_a = current_.min,
                 .current_max_a = current_.max,
                 .i_a_a = before_.plant.i_abc.a,
                 .i_b_a = before_.plant.i_abc.b,
                 .i_c_a = before_.plant.i_abc.c,
                 .flux_angle_rad = angle(estimate),
                 .speed_rad_s = before_.plant.omega_m,
                 .u_dc_v = before_.plant.u_dc,
                 .i_dc_a = link_.mean(),
                 .power_w = before_.plant.u_dc * link_.mean(),
                 .state = DriveState::torque,
                 .sector = system.comparators().sector()};
    recorder_.add_row(row);
    plant_.reset();
    torque_ = flux_ = current_ = link_ = {};
  }

 private:
  /// Mean, minimum and maximum of what runs in straight lines.
  struct Envelope {
    double sum{0}, weight{0};
    double min{std::numeric_limits<double>::infinity()};
    double max{-std::numeric_limits<double>::infinity()};

    void add(double a, double b, double seconds) noexcept {
      sum += 0.5 * seconds * (a + b);
      weight += seconds;
      min = std::min({min, a, b});
      max = std::max({max, a, b});
    }
    [[nodiscard]] double mean() const noexcept { return sum / weight; }
  };

  /// What a row is made of, at one instant; torque and flux as estimated.
  struct Look {
    PlantSample plant{};
    double torque{};   ///< [N·m]
    double flux{};     ///< [Wb]
    double current{};  ///< [A]
  };

  [[nodiscard]] Look look(const EventExactSystem& system) const noexcept {
    const EventExactSystem::Plant& p = system.plant();
    const PlantLook plant{p, p.state(), EventExactSystem::meter};
    const SpaceVector<> estimate = system.estimated_flux();
    return {.plant = plant.trace_sample(p.inputs().state, p.u_s(), tau_l_ + p.tau_road()),
            .torque = system.estimated_torque(estimate, plant.i_s),
            .flux = magnitude(estimate),
            .current = magnitude(plant.i_s)};
  }

  TraceRecorder& recorder_;
  std::int64_t interval_ns_;
  double tau_l_{0};  ///< [N·m]
  Look before_{};
  PlantEnvelope plant_{};
  Envelope torque_{};
  Envelope flux_{};
  Envelope current_{};
  Envelope link_{};
};

}  // namespace sextant
