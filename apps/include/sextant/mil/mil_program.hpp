#pragma once

#include "sextant/config/control_method.hpp"

namespace sextant {

/// The whole of `sextant-mil`: its command line, configuration, runs, traces and summaries. `own`: control
/// methods beside Sextant's, which a scenario chooses by name like any other. Messages begin with the
/// file name of argv[0]. Returns the exit status.
///
///   int main(int argc, char** argv) {
///     return sextant::mil_program(argc, argv, {sextant::control_method<MyController>()});
///   }
[[nodiscard]] int mil_program(int argc, char** argv, const ControlMethods& own = {});

}  // namespace sextant
