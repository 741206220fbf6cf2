#pragma once

#include "sextant/realtime/realtime_parameters.hpp"
#include "sextant/realtime/thread_setup.hpp"

namespace sextant::ecu {

/// Requests the priority of the watchdog for the calling thread. In hard real time it is the highest of the
/// process, so that the watchdog turns the gates off even while another thread, a control thread included,
/// never yields the processor. `control_priority`: the highest SCHED_FIFO priority of a control thread, 0 for
/// none [-]; where `watchdog_priority` is refused the watchdog requests that.
inline void request_watchdog_priority(int control_priority) {
  if (control_priority == 0 || use_fifo_scheduling(watchdog_priority).granted) return;
  // An rtprio limit may lie between the two. The control thread reports any other refusal: its own request is
  // then refused too.
  (void)use_fifo_scheduling(control_priority);
}

}  // namespace sextant::ecu
