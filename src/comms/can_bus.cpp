#include "sextant/comms/can_bus.hpp"

#include <charconv>
#include <stdexcept>
#include <string>

#include "socketcan_bus.hpp"
#include "udp_multicast_bus.hpp"

namespace sextant {
namespace {

std::uint16_t parse_port(std::string_view text, std::string_view address) {
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc{} || end != text.data() + text.size() || port == 0) {
    throw std::runtime_error("the CAN address \"" + std::string(address) +
                             "\" needs a port from 1 to 65535, as in udp_multicast:239.74.163.2:43113");
  }
  return port;
}

std::unique_ptr<CanBus> make_udp_multicast(std::string_view rest, std::string_view address,
                                           std::span<const CanIdentifier> wanted) {
  const std::size_t colon = rest.rfind(':');
  const std::string_view port = colon == std::string_view::npos ? std::string_view{} : rest.substr(colon + 1);
  return std::make_unique<UdpMulticastBus>(std::string(rest.substr(0, colon)), parse_port(port, address),
                                           wanted);
}

}  // namespace

std::unique_ptr<CanBus> make_can_bus(std::string_view address, std::span<const CanIdentifier> wanted) {
  const std::size_t colon = address.find(':');
  const std::string_view kind = address.substr(0, colon);
  const std::string_view rest =
      colon == std::string_view::npos ? std::string_view{} : address.substr(colon + 1);
  if (kind == "socketcan") return std::make_unique<SocketCanBus>(std::string(rest), wanted);
  if (kind == "udp_multicast") return make_udp_multicast(rest, address, wanted);
  throw std::runtime_error("the CAN address \"" + std::string(address) +
                           "\" is not known: use socketcan:<interface> or udp_multicast:<group>:<port>");
}

}  // namespace sextant
