#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "sextant/core/nonblocking.hpp"
#include "sextant/hil/link_datagram.hpp"

namespace sextant {

/// Judges what arrives from the other side of a network: whether it is for us, and what the network did to
/// it.
///
/// A peer that was started anew is taken up once the start before has been quiet for `quiet_ns`, as long as
/// it takes to count as dead. What a network still holds of an earlier start does therefore not displace the
/// living one; where it comes in a moment in which that is quiet itself, it is heard for `quiet_ns` at most.
/// Starts are told apart by a number at random, because no clock need be right.
class DatagramReception {
 public:
  struct Counters {
    std::uint64_t received{};       ///< datagrams of the peer, all below but the foreign included [-]
    std::uint64_t lost{};           ///< never came [-]
    std::uint64_t reordered{};      ///< came after a newer one [-]
    std::uint64_t repeated{};       ///< came again [-]
    std::uint64_t late{};           ///< took more than two periods longer than the fastest [-]
    std::uint64_t restarts{};       ///< starts of the peer that have been seen, but the first [-]
    std::uint64_t foreign{};        ///< not of this program, of another start of it, or malformed [-]
    std::uint64_t other_version{};  ///< of another version of this program [-]
    std::uint64_t other_period{};   ///< of a peer with another period [-]
  };

  DatagramReception(DatagramKind kind, std::int64_t period_ns, std::int64_t quiet_ns) noexcept
      : kind_{kind}, period_ns_{period_ns}, quiet_ns_{quiet_ns} {}

  /// True when the datagram is the peer's, whether or not something newer has come. `size`: its length
  /// [bytes]; `wanted`: that of its kind.
  [[nodiscard]] bool accept(const DatagramHeader& h, std::size_t size, std::size_t wanted,
                            std::int64_t now_ns) noexcept SEXTANT_NONBLOCKING {
    if (size < sizeof(DatagramHeader) || h.magic != datagram_magic) return refuse(counters_.foreign);
    if (h.version != link_layout_version) return refuse(counters_.other_version);
    if (h.kind != std::uint16_t(kind_) || size != wanted) return refuse(counters_.foreign);
    if (h.count < 1 || h.count > most_records()) return refuse(counters_.foreign);
    if (h.period_ns != period_ns_) return refuse(counters_.other_period);
    if (h.generation != generation_ && !is_new_start(h, now_ns)) return refuse(counters_.foreign);
    heard_ns_ = now_ns;
    ++counters_.received;
    judge_order(h.sequence);
    judge_time(transit_ns(h, now_ns), now_ns);
    return true;
  }

  [[nodiscard]] const Counters& counters() const noexcept SEXTANT_NONBLOCKING { return counters_; }

 private:
  static bool refuse(std::uint64_t& counter) noexcept SEXTANT_NONBLOCKING {
    ++counter;
    return false;
  }

  [[nodiscard]] std::uint32_t most_records() const noexcept SEXTANT_NONBLOCKING {
    return kind_ == DatagramKind::measurement ? std::uint32_t{MeasurementDatagram::capacity} : 1U;
  }

  /// The two clocks may be anywhere; unsigned, because their difference may not fit.
  [[nodiscard]] static std::int64_t transit_ns(const DatagramHeader& h,
                                               std::int64_t now_ns) noexcept SEXTANT_NONBLOCKING {
    constexpr std::int64_t far_ns = std::int64_t{1} << 62U;
    const auto difference = std::int64_t(std::uint64_t(now_ns) - std::uint64_t(h.sent_ns));
    return std::clamp(difference, -far_ns, far_ns);
  }

  /// False while the start before it lives.
  [[nodiscard]] bool is_new_start(const DatagramHeader& h, std::int64_t now_ns) noexcept SEXTANT_NONBLOCKING {
    if (h.generation == 0) return false;
    if (generation_ != 0) {
      if (now_ns - heard_ns_ <= quiet_ns_) return false;
      ++counters_.restarts;
    }
    generation_ = h.generation;
    newest_ = h.sequence - 1;
    seen_ = ~std::uint64_t{0};
    fastest_known_ = false;
    return true;
  }

  /// `seen_` has a bit for each of the last 64 numbers, the newest at bit 0.
  void judge_order(std::uint64_t sequence) noexcept SEXTANT_NONBLOCKING {
    if (sequence > newest_) {
      const std::uint64_t step = sequence - newest_;
      counters_.lost += step - 1;
      seen_ = (step < 64 ? seen_ << step : 0U) | 1U;
      newest_ = sequence;
      return;
    }
    const std::uint64_t age = newest_ - sequence;
    const std::uint64_t bit = age < 64 ? std::uint64_t{1} << age : 0U;
    if ((seen_ & bit) != 0) {
      ++counters_.repeated;
      return;
    }
    seen_ |= bit;
    ++counters_.reordered;
    if (counters_.lost > 0) --counters_.lost;
  }

  /// Against the fastest of all; the two clocks may part by 100 ppm.
  void judge_time(std::int64_t transit_ns, std::int64_t now_ns) noexcept SEXTANT_NONBLOCKING {
    if (!fastest_known_) {
      fastest_ns_ = transit_ns;
      fastest_known_ = true;
    }
    fastest_ns_ = std::min(fastest_ns_ + (now_ns - judged_ns_) / 10'000, transit_ns);
    judged_ns_ = now_ns;
    if (transit_ns > fastest_ns_ + 2 * period_ns_) ++counters_.late;
  }

  DatagramKind kind_;
  std::int64_t period_ns_;
  std::int64_t quiet_ns_;
  Counters counters_{};
  std::uint64_t newest_{0};
  std::uint64_t seen_{0};
  std::int64_t heard_ns_{0};
  std::int64_t judged_ns_{0};
  std::int64_t fastest_ns_{0};
  std::uint32_t generation_{0};
  bool fastest_known_{false};
};

}  // namespace sextant
