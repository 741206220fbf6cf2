#pragma once

#include <netinet/in.h>

namespace sextant {

/// The index of the interface over which this machine's routes send to `group`, as unbound sockets do; 0 with
/// errno where there is none (ENETUNREACH) or the kernel reports none.
[[nodiscard]] int outgoing_interface(in_addr group) noexcept;

}  // namespace sextant
