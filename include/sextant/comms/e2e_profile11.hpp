#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sextant/comms/e2e_state_machine.hpp"
#include "sextant/core/torque_command.hpp"

namespace sextant {

/// AUTOSAR E2E Profile 11, data id mode NIBBLE, on frames of eight bytes (AUTOSAR FO PRS E2EProtocol):
/// byte 0 is the CRC, byte 1 holds the counter (low nibble) and the low nibble of the data id's high byte
/// (high nibble). It detects corruption, loss, repetition and insertion; it does not stop an attacker.
namespace e2e {

inline constexpr std::size_t frame_length = 8;       ///< [bytes]
inline constexpr std::uint8_t counter_modulus = 15;  ///< counters run from 0 to 14
using Data = std::array<std::uint8_t, frame_length>;

/// Remainders of the CRC-8 of polynomial x^8 + x^4 + x^3 + x^2 + 1 (0x1D), one per byte value.
inline constexpr auto crc8_table = [] {
  std::array<std::uint8_t, 256> table{};
  for (unsigned i = 0; i < 256; ++i) {
    unsigned r = i;
    for (int bit = 0; bit < 8; ++bit) r = (r & 0x80U) != 0 ? (r << 1U) ^ 0x1DU : r << 1U;
    table[i] = static_cast<std::uint8_t>(r & 0xFFU);
  }
  return table;
}();

/// CRC over the data id's low byte, a zero byte and every byte of the frame but the first, with an effective
/// initial value and XOR-out of 0 (the profile's FF/FF cancels in its own routine).
[[nodiscard]] constexpr std::uint8_t crc(std::uint16_t data_id, const Data& data) noexcept {
  std::uint8_t r = crc8_table[data_id & 0xFFU];
  r = crc8_table[r];
  for (std::size_t i = 1; i < data.size(); ++i) r = crc8_table[static_cast<std::uint8_t>(r ^ data[i])];
  return r;
}

[[nodiscard]] constexpr std::uint8_t data_id_nibble(std::uint16_t data_id) noexcept {
  return static_cast<std::uint8_t>((data_id >> 8U) & 0x0FU);
}

[[nodiscard]] constexpr std::uint8_t counter(const Data& data) noexcept {
  return data[1] & 0x0FU;
}

/// Writes counter, data id nibble and CRC into bytes 1 and 0.
constexpr void protect(std::uint16_t data_id, std::uint8_t counter, Data& data) noexcept {
  data[1] = static_cast<std::uint8_t>((counter & 0x0FU) | (unsigned{data_id_nibble(data_id)} << 4U));
  data[0] = crc(data_id, data);
}

}  // namespace e2e

/// Result of the check of one frame.
enum class E2eResult : std::uint8_t {
  ok,               ///< the next counter
  ok_some_lost,     ///< up to `max_delta_counter` ahead: frames are missing, this one may be used
  repeated,         ///< the counter of the frame before
  wrong_sequence,   ///< further ahead than `max_delta_counter`
  invalid_counter,  ///< 15
  wrong_crc,        ///< corrupted, or protected for another data id
  wrong_data_id     ///< the CRC is right, the data id nibble is not
};

[[nodiscard]] constexpr bool usable(E2eResult r) noexcept {
  return r == E2eResult::ok || r == E2eResult::ok_some_lost;
}

/// The result as the state machine counts it: counter errors are neutral.
[[nodiscard]] constexpr E2eStateMachine::Status status_of(E2eResult r) noexcept {
  if (usable(r)) return E2eStateMachine::Status::ok;
  if (r == E2eResult::wrong_crc || r == E2eResult::wrong_data_id) return E2eStateMachine::Status::error;
  return E2eStateMachine::Status::neutral;
}

/// The sending side of one protected message: owns its counter.
class E2eProtector {
 public:
  explicit constexpr E2eProtector(std::uint16_t data_id) noexcept : data_id_(data_id) {}

  /// Protects the frame and moves the counter on.
  constexpr void protect(e2e::Data& data) noexcept {
    e2e::protect(data_id_, counter_, data);
    counter_ = static_cast<std::uint8_t>((counter_ + 1U) % e2e::counter_modulus);
  }

 private:
  std::uint16_t data_id_;
  std::uint8_t counter_{0};
};

/// The receiving side of one protected message: the check of each frame and the state of the stream.
class E2eChecker {
 public:
  struct Parameters {
    std::uint8_t max_delta_counter{3};  ///< largest step of the counter that is accepted [-]
    E2eStateMachine::Parameters state_machine{};

    [[nodiscard]] constexpr const char* validate() const noexcept {
      if (max_delta_counter < 1 || max_delta_counter >= e2e::counter_modulus) {
        return "max_delta_counter must be from 1 to 14";
      }
      return state_machine.validate();
    }
  };

  explicit constexpr E2eChecker(std::uint16_t data_id) noexcept : E2eChecker(data_id, Parameters{}) {}
  constexpr E2eChecker(std::uint16_t data_id, const Parameters& parameters) noexcept
      : data_id_(data_id), parameters_(parameters), state_machine_(parameters.state_machine) {}

  constexpr E2eResult check(const e2e::Data& data) noexcept {
    const E2eResult result = check_frame(data);
    state_machine_.add(status_of(result));
    return result;
  }

  [[nodiscard]] constexpr E2eState state() const noexcept { return state_machine_.state(); }
  constexpr void reset() noexcept { *this = E2eChecker(data_id_, parameters_); }

 private:
  constexpr E2eResult check_frame(const e2e::Data& data) noexcept {
    if (data[0] != e2e::crc(data_id_, data)) return E2eResult::wrong_crc;
    if ((data[1] >> 4U) != e2e::data_id_nibble(data_id_)) return E2eResult::wrong_data_id;
    const auto received = static_cast<std::uint8_t>(data[1] & 0x0FU);
    if (received >= e2e::counter_modulus) return E2eResult::invalid_counter;
    const unsigned delta = (unsigned{received} + e2e::counter_modulus - counter_) % e2e::counter_modulus;
    counter_ = received;  // after a jump the next frame is compared with this one
    if (delta == 0) return E2eResult::repeated;
    if (delta == 1) return E2eResult::ok;
    return delta <= parameters_.max_delta_counter ? E2eResult::ok_some_lost : E2eResult::wrong_sequence;
  }

  std::uint16_t data_id_;
  Parameters parameters_;
  std::uint8_t counter_{e2e::counter_modulus - 1};  // so that the first frame with counter 0 is OK
  E2eStateMachine state_machine_;
};

}  // namespace sextant
