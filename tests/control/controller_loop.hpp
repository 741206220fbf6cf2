#pragma once

#include "control/controlled_machine.hpp"

namespace sextant::test {

template <class C>
struct ScalarOf;
template <template <class> class C, class T>
struct ScalarOf<C<T>> {
  using Type = T;
};
/// The scalar of a controller's class.
template <class C>
using Scalar = typename ScalarOf<C>::Type;

/// A controller of any method closed around the reference machine.
template <class C>
using Loop = ControlledMachine<Scalar<C>, C>;

/// Those of the reference machine, with a period of actuation delay where there is one.
template <class C>
typename C::Parameters parameters(int delay = 1) {
  typename C::Parameters p;
  p.actuation_delay_periods = delay;
  p.magnetiser = {.current_limit = Scalar<C>(40), .hand_over_current = Scalar<C>(30)};
  return p;
}

/// Flux reference of `parameters`. [Wb]
inline constexpr double psi_ref = 1.1;

}  // namespace sextant::test
