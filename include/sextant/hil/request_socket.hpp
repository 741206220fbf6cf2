#pragma once

#include <functional>
#include <string>

namespace sextant {

/// A local socket (AF_UNIX, SOCK_SEQPACKET) that answers requests of its owner: a packet is a request, and
/// gets a packet in reply. A request of more than 4096 bytes gets a sentence that says so. Its file has the
/// mode 0600.
class RequestSocket {
 public:
  using Answer = std::function<std::string(const std::string& request)>;

  /// Throws std::runtime_error with one sentence where the socket cannot be made. The file of a program that
  /// has ended is replaced, no other one.
  RequestSocket(const std::string& file, Answer answer);
  ~RequestSocket();  ///< removes the file
  RequestSocket(const RequestSocket&) = delete;
  RequestSocket& operator=(const RequestSocket&) = delete;

  /// Answers the request that waits, if there is one; one thread calls it. A client that sends nothing is
  /// left after 100 ms.
  void poll();

 private:
  std::string file_;
  Answer answer_;
  int listening_;
};

}  // namespace sextant
