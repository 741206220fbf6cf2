#pragma once

#include <random>

#include "sextant/core/measurement.hpp"
#include "sextant/core/segment_list.hpp"

namespace sextant {

/// A drive that reads a plant over a link: each of its reads returns none of the plant's records, one, two or
/// three, the first read one, so many that none is left behind in the end. Records are joined as
/// `MeasurementAssembler` does.
template <class T>
class JoinedReads {
 public:
  explicit JoinedReads(unsigned seed) : random_{seed} {}

  /// The read of a period; `next()` is the plant's record of the next period.
  template <class Next>
  [[nodiscard]] Measurement<T> read(Next&& next) {
    ++waiting_;
    const bool is_first = last_.applied.segments().empty();
    const int taken =
        is_first || waiting_ == 3 ? waiting_ : std::uniform_int_distribution<int>{0, waiting_}(random_);
    GatePattern applied{last_.applied.last_state(), 0};
    for (int k = 0; k < taken; ++k) {
      last_ = next();
      SegmentList all;
      all.append(applied.segments());
      all.append(last_.applied.segments());
      applied = {};
      fits_ = all.join(applied) && fits_;
    }
    waiting_ -= taken;
    last_.applied = applied;
    return last_;
  }

  [[nodiscard]] bool fits() const noexcept { return fits_; }  ///< every pattern had room

 private:
  std::mt19937 random_;
  Measurement<T> last_{};
  int waiting_{0};  ///< records that are not read yet [-]
  bool fits_{true};
};

}  // namespace sextant
