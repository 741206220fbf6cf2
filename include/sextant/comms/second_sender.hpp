#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sextant/comms/e2e_profile11.hpp"

namespace sextant {

/// Detects two senders under the command's identifier, both with right CRCs, in one of two ways.
///
/// - Two vehicle control units, each in the contract's cycle time: the frames come twice as often as those of
///   one, and because the counters are independent, of two successive frames at least one does not follow
///   from the other: for counters d apart the steps are d and 16 − d, modulo 15.
/// - A sender that hides behind the other by its next counters: two frames have one counter and unlike
///   contents, and they and the frames between and before them came faster than one sender sends so many:
///   m frames in less than m − 1.5 cycles; twice within sixteen cycles, since a frame of one sender that is
///   15 cycles late does the same once.
///
/// A burst of one sender after a delay has counters in order; a frozen counter comes at the cycle time; a
/// frame that arrives twice is equal in every byte. None of these counts.
class SecondSender {
 public:
  struct Parameters {
    std::int64_t window_ns{45'000'000};  ///< over which the frames are counted [ns]
    int frames{8};                       ///< frames with a right CRC in it, twice the contract's [-]
    int out_of_order{4};                 ///< of these, that do not follow from the one before [-]
    std::int64_t cycle_ns{10'000'000};   ///< between two frames of one sender, by the contract [ns]
    std::int64_t hold_ns{200'000'000};   ///< the result stays for so long after the last such window [ns]

    [[nodiscard]] constexpr const char* validate() const noexcept {
      if (window_ns <= 0) return "the window for a second sender must be above zero";
      if (frames < 2 || frames > int(capacity)) return "the frames of a second sender must be from 2 to 32";
      if (out_of_order < 1 || out_of_order > frames) {
        return "the frames out of order must be from 1 to those of a second sender";
      }
      if (cycle_ns <= 0) return "the cycle of a sender must be above zero";
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
      if (two_send(received_ns) || hides(received_ns)) {
        seen_ns_ = received_ns;
        seen_ = true;
      }
    }
    if (seen_ && received_ns - seen_ns_ >= parameters_.hold_ns) seen_ = false;
    return seen_;
  }

 private:
  static constexpr std::size_t capacity = 32;
  /// Frames back to one of the same counter. One sender's next frame of a counter comes 15 later: as many as
  /// this are lost before it is taken for a second one.
  static constexpr std::size_t most_back = 7;
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

  /// The frame so many before the newest.
  [[nodiscard]] constexpr const Arrival& back(std::size_t n) const noexcept {
    return frames_[(next_ + capacity - 1 - n) % capacity];
  }

  /// Whether one sender hides behind another, by the newest frame and one before.
  constexpr bool hides(std::int64_t now_ns) noexcept {
    if (!has_unlike_twin()) return false;
    const bool again = has_twin_ && now_ns - twin_ns_ <= 16 * parameters_.cycle_ns;
    has_twin_ = true;
    twin_ns_ = now_ns;
    return again;
  }

  /// Whether the newest frame has the counter of another one that cannot be of the same sender.
  [[nodiscard]] constexpr bool has_unlike_twin() const noexcept {
    for (std::size_t n = 1; n <= most_back && n + 1 < count_; ++n) {
      if (e2e::counter(back(n).data) != e2e::counter(back(0).data) || back(n).data == back(0).data) continue;
      const std::int64_t took_ns = back(0).received_ns - back(n + 1).received_ns;
      // n + 2 frames, from that before the first of the two on.
      if (2 * took_ns <= std::int64_t(2 * n + 1) * parameters_.cycle_ns) return true;
    }
    return false;
  }

  Parameters parameters_;
  std::array<Arrival, capacity> frames_{};
  std::size_t next_{0};
  std::size_t count_{0};
  std::int64_t seen_ns_{0};
  std::int64_t twin_ns_{0};  // of the last frame with a twin
  bool has_twin_{false};
  bool seen_{false};
};

}  // namespace sextant
