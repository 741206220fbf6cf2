#include "can_datagram.hpp"

#include <algorithm>
#include <string_view>

#include <msgpack.hpp>

namespace sextant {
namespace {

/// What msgpack writes into. The longest datagram fits: 64 data bytes and less than 200 of keys.
class Sink {
 public:
  explicit Sink(CanDatagram& datagram) noexcept : datagram_(datagram) {}

  void write(const char* bytes, std::size_t n) noexcept {
    const std::size_t fits = std::min(n, datagram_.bytes.size() - datagram_.length);
    std::copy_n(bytes, fits, datagram_.bytes.data() + datagram_.length);
    datagram_.length += fits;
  }

 private:
  CanDatagram& datagram_;
};

constexpr std::uint32_t standard_id_mask = 0x7FF;
constexpr std::uint32_t extended_id_mask = 0x1FFFFFFF;

struct Fields {
  CanFrame frame;
  std::size_t dlc{0};
  std::size_t data_length{0};
  bool has_id{false};
};

bool read_integer(const msgpack::object& value, std::uint64_t limit, std::uint64_t& out) noexcept {
  if (value.type != msgpack::type::POSITIVE_INTEGER || value.via.u64 > limit) return false;
  out = value.via.u64;
  return true;
}

bool read_flag(const msgpack::object& value, bool& out) noexcept {
  if (value.type != msgpack::type::BOOLEAN) return false;
  out = value.via.boolean;
  return true;
}

bool read_data(const msgpack::object& value, Fields& fields) noexcept {
  if (value.type == msgpack::type::NIL) return true;
  if (value.type != msgpack::type::BIN || value.via.bin.size > fields.frame.data.size()) return false;
  fields.data_length = value.via.bin.size;
  std::transform(value.via.bin.ptr, value.via.bin.ptr + fields.data_length, fields.frame.data.begin(),
                 [](char c) { return static_cast<std::uint8_t>(c); });
  return true;
}

bool read_field(std::string_view key, const msgpack::object& value, Fields& fields) noexcept {
  std::uint64_t number = 0;
  if (key == "arbitration_id") {
    if (!read_integer(value, extended_id_mask, number)) return false;
    fields.frame.id = static_cast<std::uint32_t>(number);
    return fields.has_id = true;
  }
  if (key == "dlc") {
    if (!read_integer(value, fields.frame.data.size(), number)) return false;
    fields.dlc = number;
    return true;
  }
  if (key == "data") return read_data(value, fields);
  if (key == "is_extended_id") return read_flag(value, fields.frame.extended);
  if (key == "is_remote_frame") return read_flag(value, fields.frame.rtr);
  if (key == "is_error_frame") return read_flag(value, fields.frame.error);
  if (key == "is_fd") return read_flag(value, fields.frame.fd);
  return true;
}

bool consistent(const Fields& fields) noexcept {
  const CanFrame& f = fields.frame;
  if (!fields.has_id || (!f.extended && !f.error && f.id > standard_id_mask)) return false;
  if (!f.fd && fields.dlc > 8) return false;
  return f.rtr || f.error || fields.data_length == fields.dlc;
}

}  // namespace

CanDatagram pack_datagram(const CanFrame& frame, double timestamp) noexcept {
  CanDatagram datagram;
  Sink sink(datagram);
  msgpack::packer<Sink> packer(sink);
  const auto key = [&packer](std::string_view name) -> msgpack::packer<Sink>& {
    packer.pack_str(static_cast<std::uint32_t>(name.size()));
    return packer.pack_str_body(name.data(), static_cast<std::uint32_t>(name.size()));
  };
  const auto flag = [](msgpack::packer<Sink>& p, bool value) { value ? p.pack_true() : p.pack_false(); };
  const std::uint32_t data_length = frame.rtr ? 0U : frame.length;

  packer.pack_map(11);
  key("timestamp").pack_double(timestamp);
  key("arbitration_id").pack_uint32(frame.id);
  flag(key("is_extended_id"), frame.extended);
  flag(key("is_remote_frame"), frame.rtr);
  flag(key("is_error_frame"), frame.error);
  key("channel").pack_nil();
  key("dlc").pack_uint8(frame.length);
  std::array<char, 64> data{};
  std::transform(frame.data.begin(), frame.data.end(), data.begin(),
                 [](std::uint8_t byte) { return static_cast<char>(byte); });
  key("data").pack_bin(data_length).pack_bin_body(data.data(), data_length);
  flag(key("is_fd"), frame.fd);
  flag(key("bitrate_switch"), false);
  flag(key("error_state_indicator"), false);
  return datagram;
}

std::optional<CanFrame> unpack_datagram(std::span<const char> bytes) noexcept {
  // The limits keep a hostile length field from reserving memory.
  const msgpack::unpack_limit limits(16, 32, 256, 64, 0, 4);
  try {
    std::size_t offset = 0;
    const msgpack::object_handle handle =
        msgpack::unpack(bytes.data(), bytes.size(), offset, nullptr, nullptr, limits);
    const msgpack::object& map = handle.get();
    if (map.type != msgpack::type::MAP || offset != bytes.size()) return {};
    Fields fields;
    fields.frame.extended = true;  // python-can's default
    for (const msgpack::object_kv& entry : std::span(map.via.map.ptr, map.via.map.size)) {
      if (entry.key.type != msgpack::type::STR) return {};
      const std::string_view key(entry.key.via.str.ptr, entry.key.via.str.size);
      if (!read_field(key, entry.val, fields)) return {};
    }
    if (!consistent(fields)) return {};
    fields.frame.length = static_cast<std::uint8_t>(fields.dlc);
    return fields.frame;
  } catch (const std::exception&) {
    return {};
  }
}

}  // namespace sextant
