#pragma once

namespace sextant::bench {

/// One Runge-Kutta step of the induction machine as one would write it by hand for the paper's machine: the
/// yardstick for `FixedStepIntegrator`. Same six equations, driven inverter, free shaft.
struct ReferenceRk4 {
  double x[6]{};

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
  static constexpr double r_s = 0.435, r_r = 0.816, l_l = 0.0024000565427, l_m = 0.083174, l_r = l_l + l_m;
  static constexpr double k_r = l_m / l_r, sigma_l_s = l_r - l_m * k_r, p = 2.0, inertia = 0.089;

  static void slope(const double* x, double u_a, double u_b, double tau_l, double* dx) {
    const double is_a = (x[0] - k_r * x[2]) * (1.0 / sigma_l_s), is_b = (x[1] - k_r * x[3]) * (1.0 / sigma_l_s);
    const double ir_a = x[2] * (1.0 / l_r) - k_r * is_a, ir_b = x[3] * (1.0 / l_r) - k_r * is_b;
    dx[0] = u_a - r_s * is_a;
    dx[1] = u_b - r_s * is_b;
    dx[2] = -r_r * ir_a - p * x[4] * x[3];
    dx[3] = -r_r * ir_b + p * x[4] * x[2];
    dx[4] = (1.5 * p * (x[0] * is_b - x[1] * is_a) - tau_l) * (1.0 / inertia);
    dx[5] = x[4];
  }
};

}  // namespace sextant::bench
