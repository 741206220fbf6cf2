// Requests of a client, as scripts/inject sends them.
#include "sextant/hil/request_socket.hpp"

#include <array>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace sextant {
namespace {

class RequestSocketTest : public ::testing::Test {
 protected:
  ~RequestSocketTest() override {
    if (client_ >= 0) ::close(client_);
  }

  /// The reply to a packet.
  std::string reply_to(const std::string& request) {
    client_ = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, file_.c_str(), file_.size());
    EXPECT_EQ(::connect(client_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::send(client_, request.data(), request.size(), 0), ssize_t(request.size()));
    socket_.poll();
    std::array<char, 256> reply{};
    const ssize_t length = ::recv(client_, reply.data(), reply.size(), 0);
    return length > 0 ? std::string{reply.data(), std::size_t(length)} : std::string{};
  }

  std::vector<std::string> taken_{};

 private:
  std::string file_ =
      (std::filesystem::temp_directory_path() / ("sextant_request_socket_test_" + std::to_string(::getpid())))
          .string();
  RequestSocket socket_{file_, [this](const std::string& request) {
                          taken_.push_back(request);
                          return std::string{"ok"};
                        }};
  int client_{-1};
};

TEST_F(RequestSocketTest, TheLongestRequestIsTakenWhole) {
  const std::string request(4096, 'x');
  EXPECT_EQ(reply_to(request), "ok");
  EXPECT_EQ(taken_, std::vector{request});
}

TEST_F(RequestSocketTest, ALongerRequestIsRefusedAndNotCut) {
  EXPECT_EQ(reply_to(std::string(4097, 'x')), "the request is longer than 4096 bytes");
  EXPECT_TRUE(taken_.empty());
}

}  // namespace
}  // namespace sextant
