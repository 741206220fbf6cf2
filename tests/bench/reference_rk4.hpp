#pragma once

namespace sextant::bench {

/// One Runge-Kutta step of the induction machine as one would write it by hand: the yardstick for
/// `FixedStepIntegrator`. Same six equations, parameters set at run time, driven inverter, free shaft.
struct ReferenceRk4 {
  double x[6]{};
  double r_s = 0.435, r_r = 0.816, k_r = 0.0, inv_l_r = 0.0, inv_sigma_l_s = 0.0, p = 2.0,
         inv_j = 1.0 / 0.089;

  ReferenceRk4() {
    const double l_l = 0.0024000565427, l_m = 0.083174, l_r = l_l + l_m;
    k_r = l_m / l_r;
    inv_l_r = 1.0 / l_r;
    inv_sigma_l_s = 1.0 / (l_r - l_m * k_r);
  }

  /// Stator and rotor flux linkage, speed, angle, in the order of DrivePlant.
  void set_state(const auto& begin) {
    for (int i = 0; i < 6; ++i) x[i] = begin[i];
  }

  /// Stator current in the stationary frame. [A]
  [[nodiscard]] double i_s_a() const { return (x[0] - k_r * x[2]) * inv_sigma_l_s; }
  [[nodiscard]] double i_s_b() const { return (x[1] - k_r * x[3]) * inv_sigma_l_s; }

  void step(double u_a, double u_b, double tau_l, double h) {
    double k1[6], k2[6], k3[6], k4[6], y[6];
    slope(x, u_a, u_b, tau_l, k1);
    for (int i = 0; i < 6; ++i) y[i] = x[i] + 0.5 * h * k1[i];
    slope(y, u_a, u_b, tau_l, k2);
    for (int i = 0; i < 6; ++i) y[i] = x[i] + 0.5 * h * k2[i];
    slope(y, u_a, u_b, tau_l, k3);
    for (int i = 0; i < 6; ++i) y[i] = x[i] + h * k3[i];
    slope(y, u_a, u_b, tau_l, k4);
    for (int i = 0; i < 6; ++i) x[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
  }

 private:
  void slope(const double* y, double u_a, double u_b, double tau_l, double* dx) const {
    const double is_a = (y[0] - k_r * y[2]) * inv_sigma_l_s, is_b = (y[1] - k_r * y[3]) * inv_sigma_l_s;
    const double ir_a = y[2] * inv_l_r - k_r * is_a, ir_b = y[3] * inv_l_r - k_r * is_b;
    dx[0] = u_a - r_s * is_a;
    dx[1] = u_b - r_s * is_b;
    dx[2] = -r_r * ir_a - p * y[4] * y[3];
    dx[3] = -r_r * ir_b + p * y[4] * y[2];
    dx[4] = (1.5 * p * (y[0] * is_b - y[1] * is_a) - tau_l) * inv_j;
    dx[5] = y[4];
  }
};

}  // namespace sextant::bench
