#pragma once

#include <limits>

#include <Eigen/Core>

namespace sextant {

/// Mean, variance, minimum and maximum of n quantities, from pieces over which they run linearly. The weight
/// of a piece is the caller's choice.
///
/// The sums are those of the deviation from the first value: they do not cancel as sums of squares do and
/// need no division for each value, as Welford's recurrence does (Chan, Golub, LeVeque: Algorithms for
/// Computing the Sample Variance, The American Statistician 37(3), 1983).
template <int n>
class Moments {
 public:
  using Values = Eigen::Array<double, n, 1>;

  /// Adds straight lines from a to b. Along them the mean square is the square of the middle and (b − a)²/12.
  void add_line(const Values& a, const Values& b, double weight) noexcept {
    if (weight_ == 0) origin_ = a;
    const Values middle = 0.5 * (a + b) - origin_;
    const Values rise = b - a;
    weight_ += weight;
    sum_ += weight * middle;
    sum_of_squares_ += weight * (middle * middle + (1.0 / 12) * (rise * rise));
    min_ = min_.min(a.min(b));
    max_ = max_.max(a.max(b));
  }

  /// Zero while nothing has been added; the rest has no meaning then.
  [[nodiscard]] double weight() const noexcept { return weight_; }
  [[nodiscard]] Values mean() const noexcept { return origin_ + sum_ / weight_; }
  [[nodiscard]] Values variance() const noexcept {
    return (sum_of_squares_ / weight_ - (sum_ / weight_).square()).max(0);
  }
  [[nodiscard]] const Values& min() const noexcept { return min_; }
  [[nodiscard]] const Values& max() const noexcept { return max_; }

 private:
  Values origin_ = Values::Zero();
  Values sum_ = Values::Zero();             // of weight and deviation from the origin
  Values sum_of_squares_ = Values::Zero();  // of weight and its square
  Values min_ = Values::Constant(std::numeric_limits<double>::infinity());
  Values max_ = Values::Constant(-std::numeric_limits<double>::infinity());
  double weight_{0};
};

}  // namespace sextant
