#pragma once

#include <sundials/sundials_context.h>
#include <sundials/sundials_nvector.h>

namespace sextant {

/// A serial N_Vector for a handful of states. SUNDIALS' own operations choose among special cases before they
/// loop, which costs more than the loop itself; the three that CVODE calls most are replaced by plain loops,
/// which halves the time of a segment. leaves_last_out: the last state does not count in the weighted norm.
/// Clones inherit them. nullptr when memory is out.
[[nodiscard]] N_Vector new_small_vector(int size, bool leaves_last_out, SUNContext context) noexcept;

/// The same for one-step methods, whose stages are sums of many vectors: the sum is taken in one loop too.
[[nodiscard]] N_Vector new_runge_kutta_vector(int size, bool leaves_last_out, SUNContext context) noexcept;

}  // namespace sextant
