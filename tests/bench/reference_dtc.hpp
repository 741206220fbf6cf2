#pragma once

#include <cmath>

namespace sextant::bench {

/// The conventional DTC step as one would write it by hand, without abstractions: the yardstick for
/// `DirectTorqueController`. Parameters set at run time. Same arithmetic: trapezoidal voltage model, relay
/// comparators, six sector edges, switching table, zero vector by fewest commutations, flux priority, torque
/// trim. It is told which vector applied (its upper switches as bits) and for how long, and returns the
/// vector number.
class ReferenceDtc {
 public:
  ReferenceDtc() noexcept {
    const double pi = std::acos(-1.0);
    for (int n = 0; n < 6; ++n) {
      edge_a_[n] = std::cos((-30.0 + 60.0 * n) * pi / 180.0);
      edge_b_[n] = std::sin((-30.0 + 60.0 * n) * pi / 180.0);
    }
    for (int v = 0; v < 8; ++v) {
      const double a = v & 1, b = (v >> 1) & 1, c = (v >> 2) & 1;
      u_a_[v] = (2.0 * a - b - c) / 3.0;
      u_b_[v] = (b - c) / std::sqrt(3.0);
    }
  }

  /// Back to the state after power-up.
  void reset() {
    psi_a_ = psi_b_ = ia_ = ib_ = psi_ = tau_ = 0.0;
    torque_ = sector_ = vector_ = 0;
    trim_ = miss_ = 0.0;
    raise_ = true;
    follows_ = false;
  }

  int step(double i_a, double i_b, double i_c, double u_dc, int applied, int applied_ns, double t_ref) {
    const double dt = applied_ns * 1e-9;
    const double ia = (2.0 * i_a - i_b - i_c) / 3.0;
    const double ib = (i_b - i_c) * 0.57735026918962576;
    psi_a_ += dt * (u_dc * u_a_[applied] - r_s * 0.5 * (ia + ia_));
    psi_b_ += dt * (u_dc * u_b_[applied] - r_s * 0.5 * (ib + ib_));
    ia_ = ia;
    ib_ = ib;
    const double psi = std::sqrt(psi_a_ * psi_a_ + psi_b_ * psi_b_);
    const double tau_before = tau_;
    psi_ = psi;
    tau_ = 1.5 * p * (psi_a_ * ib - psi_b_ * ia);
    const double most = p * period / sigma_l_s * psi_ref * u_dc;
    const double miss = t_ref + trim_ - tau_;
    follows_ = std::abs(miss) <= 2.0 * most && (follows_ || miss * miss_ < 0.0);
    if (follows_) trim_ += period / (trim_time + period) * (t_ref - 0.5 * (tau_before + tau_));
    if (trim_ > most) trim_ = most;
    if (trim_ < -most) trim_ = -most;
    miss_ = miss;
    const double error = t_ref + trim_ - tau_;
    if (torque_ > 0 && error < 0.0) torque_ = 0;
    if (torque_ < 0 && error > 0.0) torque_ = 0;
    if (torque_ == 0) torque_ = error > band ? 1 : error < -band ? -1 : 0;
    const double flux_error = psi_ref - psi;
    if (raise_ ? flux_error < -flux_band : flux_error > flux_band) raise_ = !raise_;
    for (int k = 0; k < 3; ++k) {
      const int next = sector_ == 5 ? 0 : sector_ + 1;
      if (edge_a_[sector_] * psi_b_ - edge_b_[sector_] * psi_a_ < 0.0) {
        sector_ = sector_ == 0 ? 5 : sector_ - 1;
      } else if (psi_a_ * edge_b_[next] - psi_b_ * edge_a_[next] < 0.0) {
        sector_ = next;
      } else {
        break;
      }
    }
    int entry = table[sector_][raise_][torque_ + 1];
    if (torque_ == 0 && flux_error > flux_band && psi_a_ * ia + psi_b_ * ib <= i_mag * psi)
      entry = sector_ + 1;
    const int high = (legs[vector_] & 1) + ((legs[vector_] >> 1) & 1) + ((legs[vector_] >> 2) & 1);
    vector_ = entry != 0 ? entry : high <= 1 ? 0 : 7;
    return vector_;
  }

  /// The estimate of the last step, and the sector 0…5.
  [[nodiscard]] double psi_a() const { return psi_a_; }
  [[nodiscard]] double psi_b() const { return psi_b_; }
  [[nodiscard]] double psi() const { return psi_; }
  [[nodiscard]] double torque() const { return tau_; }
  [[nodiscard]] int sector() const { return sector_; }

 private:
  double r_s = 0.435, band = 0.918, flux_band = 0.01, psi_ref = 1.1, p = 2.0, i_mag = 40.0;
  double l_l = 0.0024000565427, l_m = 0.083174, period = 25e-6, trim_time = 0.01;
  double sigma_l_s = l_l + l_m * l_l / (l_l + l_m);
  static constexpr int legs[8] = {0, 1, 3, 2, 6, 4, 5, 7};
  static constexpr int table[6][2][3] = {{{5, 0, 3}, {6, 0, 2}}, {{6, 0, 4}, {1, 0, 3}},
                                         {{1, 0, 5}, {2, 0, 4}}, {{2, 0, 6}, {3, 0, 5}},
                                         {{3, 0, 1}, {4, 0, 6}}, {{4, 0, 2}, {5, 0, 1}}};
  double edge_a_[6]{}, edge_b_[6]{}, u_a_[8]{}, u_b_[8]{};
  double psi_a_{}, psi_b_{}, ia_{}, ib_{}, psi_{}, tau_{}, trim_{}, miss_{};
  int torque_{0}, sector_{0}, vector_{0};
  bool raise_{true}, follows_{false};
};

}  // namespace sextant::bench
