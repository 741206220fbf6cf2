#pragma once

#include <string>

#include "ecu/parameters/parameter_changes.hpp"
#include "sextant/hil/request_socket.hpp"

namespace sextant::ecu {

/// Parameters of the running drive by requests on a local socket. A request has a line `key=value` for each
/// key that it sets; all are taken at once, or none. The reply is "ok" with a line for each value that has
/// become another one, or the sentences of what is wrong. The request `describe` has the keys with their
/// values as its reply (`running_keys`). Every set that is taken is logged.
class ParameterService {
 public:
  /// The changes are not owned and must outlive this object. Throws as RequestSocket. log_prefix: of its
  /// lines in the log.
  ParameterService(const std::string& socket, ParameterChanges& changes, std::string log_prefix = {});

  /// Answers the request that waits, if there is one; one thread calls it. It waits for the control thread,
  /// for 200 ms at most.
  void poll() {
    if (waits_) (void)outcome();
    socket_.poll();
  }

 private:
  [[nodiscard]] std::string answer(const std::string& request);
  [[nodiscard]] std::string outcome_of_offer();
  /// Of the last offer; logged once, when it is taken.
  [[nodiscard]] ParameterChanges::Outcome outcome();

  ParameterChanges& changes_;
  std::string log_prefix_;
  RequestSocket socket_;
  bool waits_{false};  ///< for the outcome of an offer
};

}  // namespace sextant::ecu
