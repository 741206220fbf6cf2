#include "small_vector.hpp"

#include <cmath>

#include <nvector/nvector_serial.h>

namespace sextant {
namespace {

/// z = a x + b y.
void linear_sum(sunrealtype a, N_Vector x, sunrealtype b, N_Vector y, N_Vector z) {
  const sunindextype n = NV_LENGTH_S(x);
  const sunrealtype* const xs = NV_DATA_S(x);
  const sunrealtype* const ys = NV_DATA_S(y);
  sunrealtype* const zs = NV_DATA_S(z);
  for (sunindextype i = 0; i < n; ++i) zs[i] = a * xs[i] + b * ys[i];
}

/// z = a x.
void scale(sunrealtype a, N_Vector x, N_Vector z) {
  const sunindextype n = NV_LENGTH_S(x);
  const sunrealtype* const xs = NV_DATA_S(x);
  sunrealtype* const zs = NV_DATA_S(z);
  for (sunindextype i = 0; i < n; ++i) zs[i] = a * xs[i];
}

/// √(Σ (x w)² / n) over the first n elements, all but those left out.
template <sunindextype left_out>
sunrealtype weighted_rms_norm(N_Vector x, N_Vector w) {
  const sunindextype n = NV_LENGTH_S(x) - left_out;
  const sunrealtype* const xs = NV_DATA_S(x);
  const sunrealtype* const ws = NV_DATA_S(w);
  sunrealtype sum = 0.0;
  for (sunindextype i = 0; i < n; ++i) sum += (xs[i] * ws[i]) * (xs[i] * ws[i]);
  return std::sqrt(sum / static_cast<sunrealtype>(n));
}

/// z = Σ c_k x_k; z may be x_0.
int linear_combination(int count, sunrealtype* c, N_Vector* x, N_Vector z) {
  const sunindextype n = NV_LENGTH_S(z);
  sunrealtype* const zs = NV_DATA_S(z);
  const sunrealtype* const first = NV_DATA_S(x[0]);
  for (sunindextype i = 0; i < n; ++i) zs[i] = c[0] * first[i];
  for (int k = 1; k < count; ++k) {
    const sunrealtype* const xs = NV_DATA_S(x[k]);
    for (sunindextype i = 0; i < n; ++i) zs[i] += c[k] * xs[i];
  }
  return 0;
}

}  // namespace

N_Vector new_small_vector(int size, bool leaves_last_out, SUNContext context) noexcept {
  const N_Vector v = N_VNew_Serial(size, context);
  if (v == nullptr) return nullptr;
  v->ops->nvlinearsum = linear_sum;
  v->ops->nvscale = scale;
  v->ops->nvwrmsnorm = leaves_last_out ? weighted_rms_norm<1> : weighted_rms_norm<0>;
  return v;
}

N_Vector new_runge_kutta_vector(int size, bool leaves_last_out, SUNContext context) noexcept {
  const N_Vector v = new_small_vector(size, leaves_last_out, context);
  if (v != nullptr) v->ops->nvlinearcombination = linear_combination;
  return v;
}

}  // namespace sextant
