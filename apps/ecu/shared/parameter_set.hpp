#pragma once

#include <cstdint>

#include "sextant/core/changes.hpp"
#include "sextant/drive/drive.hpp"

namespace sextant::ecu {

/// Parameters for the running drive: those of a drive that has been built with them.
struct ParameterSet {
  std::uint64_t number{0};          ///< from 1 on [-]
  Changes changes{Changes::never};  ///< when it may be taken: `always` or `when_ready`
  Drive<double>* drive{nullptr};    ///< not owned
};

}  // namespace sextant::ecu
