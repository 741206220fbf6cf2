#pragma once

namespace sextant {

/// False where the HDF5 library is not built for threads, several of which then may not write traces.
[[nodiscard]] bool may_write_traces_from_threads() noexcept;

}  // namespace sextant
