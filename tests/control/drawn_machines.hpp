#pragma once

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "sextant/control/parameter_covariance.hpp"
#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant::test {

/// Machines of which R_s, R_r and L_m are drawn by the prior, about those of the default machine: what a user
/// configures wrongly, and a common warming.
class DrawnMachines {
 public:
  using Machine = InductionMachineParameters<double>;
  using Prior = ParameterPrior<double>;

  explicit DrawnMachines(unsigned seed) : random_{seed} {}

  [[nodiscard]] Machine next() {
    const double common = Prior::warming * normal_(random_);
    Machine m;
    m.r_s *= factor(Prior::r_s_deviation, common);
    m.r_r *= factor(Prior::r_r_deviation, common);
    m.l_m *= factor(Prior::l_deviation, 0);
    return m;
  }
  [[nodiscard]] double between(double lowest, double highest) {
    return std::uniform_real_distribution<double>{lowest, highest}(random_);
  }
  [[nodiscard]] double normal() { return normal_(random_); }

 private:
  /// Within what the sensitivities of first order bear. [-]
  [[nodiscard]] double factor(double deviation, double common) {
    const double own = std::sqrt(deviation * deviation - (common == 0 ? 0 : Prior::warming * Prior::warming));
    double x = 0;
    do {
      x = 1 + own * normal_(random_) + common;
    } while (x < 0.4 || x > 2.3);
    return x;
  }

  std::mt19937 random_;
  std::normal_distribution<double> normal_{};
};

/// Errors of one parameter over many machines, as multiples of the deviation that was told.
class Coverage {
 public:
  void add(double real, double used, double deviation) {
    const double error = std::abs(real / used - 1) / deviation;
    ++count_;
    within_ += error < 2 ? 1 : 0;
    squares_ += error * error;
    told_ += deviation;
  }
  /// The deviations are those of the errors: at least 90 % within two (95 % of a normal distribution), mean
  /// square no more than 1.3²; what is told is at most `most` in the mean.
  void expect_honest(const char* name, double most) const {
    EXPECT_GE(within_, 0.9 * count_) << name;
    EXPECT_LT(std::sqrt(squares_ / count_), 1.3) << name;
    EXPECT_LT(told_ / count_, most) << name;
  }

 private:
  int count_{0};
  int within_{0};
  double squares_{0};
  double told_{0};
};

struct MachineCoverage {
  Coverage r_s, r_r, l_m;

  void add(const DrawnMachines::Machine& real, const DrawnMachines::Machine& used,
           const ParameterDeviations<double>& told) {
    r_s.add(real.r_s, used.r_s, told.r_s);
    r_r.add(real.r_r, used.r_r, told.r_r);
    l_m.add(real.l_m, used.l_m, told.l_m);
  }
};

}  // namespace sextant::test
