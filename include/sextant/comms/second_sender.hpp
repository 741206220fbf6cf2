#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sextant/comms/e2e_profile11.hpp"

namespace sextant {

/// Detects two vehicle control units that send under one identifier, each in the contract's cycle time. Both
/// have right CRCs; their frames come twice as often as those of one, and because their counters are
/// independent, of two successive frames at least one does not follow from the other: for counters d apart
/// the steps are d and 16 − d, modulo 15. A burst of one sender after a delay has counters in order; a frozen
/// counter comes at the cycle time; a frame that arrives twice is equal in every byte. None of these counts.
class SecondSender {
 public:
  struct Parameters {
    std::int64_t window_ns{45'000'000};  ///< over which the frames are counted [ns]
    int frames{8};                       ///< frames with a right CRC in it, twice the contract's [-]
    int out_of_order{4};                 ///< of these, that do not follow from the one before [-]
    std::int64_t hold_ns{200'000'000};   ///< the result stays for so long after the last such window [ns]

    [[nodiscard]] constexpr const char* validate() const noexcept {
      if (window_ns <= 0) return "the window for a second sender must be above zero";
      if (frames < 2 || frames > int(capacity)) return "the frames of a second sender must be from 2 to 32";
      if (out_of_order < 1 || out_of_order > frames) {
        return "the frames out of order must be from 1 to those of a second sender";
      }
      return hold_ns >= 0 ? nullptr : "a second sender must not be held for less than zero";
    }
  };

  constexpr SecondSender() noexcept : SecondSender(Parameters{}) {}
  explicit constexpr SecondSender(const Parameters& parameters) noexcept : parameters_{parameters} {}

  /// A frame under the command's identifier, its check and its arrival [ns]; true while there is another
  /// sender.
  constexpr bool add(const e2e::Data& data, E2eResult result, std::int64_t received_ns) noexcept {
    const bool jumps = result == E2eResult::repeated || result == E2eResult::wrong_sequence;
    if ((usable(result) || jumps) && !has_come(data, received_ns)) {
      frames_[next_] = {data, received_ns, jumps};
      next_ = (next_ + 1) % capacity;
      if (count_ < capacity) ++count_;
      if (two_send(received_ns)) {
        seen_ns_ = received_ns;
        seen_ = true;
      }
    }
    if (seen_ && received_ns - seen_ns_ >= parameters_.hold_ns) seen_ = false;
    return seen_;
  }

 private:
  static constexpr std::size_t capacity = 32;
  struct Arrival {
    e2e::Data data{};
    std::int64_t received_ns{};
    bool jumps{};
  };

  [[nodiscard]] constexpr bool is_recent(std::size_t n, std::int64_t now_ns) const noexcept {
    return now_ns - frames_[n].received_ns < parameters_.window_ns;
  }

  [[nodiscard]] constexpr bool has_come(const e2e::Data& data, std::int64_t now_ns) const noexcept {
    for (std::size_t n = 0; n < count_; ++n) {
      if (is_recent(n, now_ns) && frames_[n].data == data) return true;
    }
    return false;
  }

  [[nodiscard]] constexpr bool two_send(std::int64_t now_ns) const noexcept {
    int frames = 0;
    int out_of_order = 0;
    for (std::size_t n = 0; n < count_; ++n) {
      if (!is_recent(n, now_ns)) continue;
      ++frames;
      out_of_order += frames_[n].jumps ? 1 : 0;
    }
    return frames >= parameters_.frames && out_of_order >= parameters_.out_of_order;
  }

  Parameters parameters_;
  std::array<Arrival, capacity> frames_{};
  std::size_t next_{0};
  std::size_t count_{0};
  std::int64_t seen_ns_{0};
  bool seen_{false};
};

}  // namespace sextant
