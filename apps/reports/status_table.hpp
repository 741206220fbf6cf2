#pragma once

#include <string>

namespace sextant::reports {

/// A line for each verdict, and that of a run that cannot start, for the help of a program.
[[nodiscard]] std::string verdict_status_table();

}  // namespace sextant::reports
