#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "sextant/core/nonblocking.hpp"
#include "sextant/hil/link_datagram.hpp"

namespace sextant {

/// Evaluates received datagrams: accepts those of the peer, and counts losses, reordering, repetition and
/// delay.
///
/// A new start of the peer is accepted once the start before has sent nothing for `quiet_ns`, its timeout.
/// Delayed datagrams of an earlier start therefore do not replace a running one; during a pause of the
/// running one they are accepted for at most `quiet_ns`. A random number identifies each start, because
/// clocks may be wrong.
///
/// A number beyond what the peer can have reached since its last datagram, twice one a period and 64 more, is
/// refused: alone it would make all that the peer sends afterwards old. The fourth of four that follow each
/// other is accepted: the receiver stood still for longer than its queue lasts.
class DatagramReception {
 public:
  struct Counters {
    std::uint64_t received{};       ///< datagrams of the peer, all below but the foreign included [-]
    std::uint64_t lost{};           ///< not received [-]
    std::uint64_t reordered{};      ///< received after a newer one [-]
    std::uint64_t repeated{};       ///< received again [-]
    std::uint64_t late{};           ///< took more than two periods longer than the fastest [-]
    std::uint64_t restarts{};       ///< starts of the peer after the first [-]
    std::uint64_t foreign{};        ///< not of this program, of another start of it, malformed, or with a
                                    ///< number out of reach [-]
    std::uint64_t other_version{};  ///< of another version of this program [-]
    std::uint64_t other_period{};   ///< of a peer with another period [-]
  };

  DatagramReception(DatagramKind kind, std::int64_t period_ns, std::int64_t quiet_ns) noexcept
      : kind_{kind}, period_ns_{period_ns}, quiet_ns_{quiet_ns} {}

  /// True when the datagram is the peer's, also after a newer one. `size`: its length [bytes]; `wanted`: that
  /// of its kind.
  [[nodiscard]] bool accept(const DatagramHeader& h, std::size_t size, std::size_t wanted,
                            std::int64_t now_ns) noexcept SEXTANT_NONBLOCKING {
    if (size < sizeof(DatagramHeader) || h.magic != datagram_magic) return refuse(counters_.foreign);
    if (h.version != link_layout_version) return refuse(counters_.other_version);
    if (h.kind != std::uint16_t(kind_) || size != wanted) return refuse(counters_.foreign);
    if (h.count < 1 || h.count > most_records()) return refuse(counters_.foreign);
    if (h.period_ns != period_ns_) return refuse(counters_.other_period);
    if (h.generation != generation_ && !is_new_start(h, now_ns)) return refuse(counters_.foreign);
    if (!is_in_reach(h.sequence, now_ns) && !goes_on(h.sequence)) return refuse(counters_.foreign);
    last_datagram_ns_ = now_ns;
    ++counters_.received;
    evaluate_order(h.sequence);
    evaluate_transit(transit_ns(h, now_ns), now_ns);
    return true;
  }

  /// Counts an accepted datagram whose records are not of its header.
  void count_malformed() noexcept SEXTANT_NONBLOCKING { ++counters_.foreign; }

  [[nodiscard]] const Counters& counters() const noexcept SEXTANT_NONBLOCKING { return counters_; }

 private:
  static bool refuse(std::uint64_t& counter) noexcept SEXTANT_NONBLOCKING {
    ++counter;
    return false;
  }

  [[nodiscard]] std::uint32_t most_records() const noexcept SEXTANT_NONBLOCKING {
    return kind_ == DatagramKind::measurement ? std::uint32_t{MeasurementDatagram::capacity} : 1U;
  }

  /// Difference of the two sides' clocks plus the delay; unsigned arithmetic, because it may not fit.
  [[nodiscard]] static std::int64_t transit_ns(const DatagramHeader& h,
                                               std::int64_t now_ns) noexcept SEXTANT_NONBLOCKING {
    constexpr std::int64_t far_ns = std::int64_t{1} << 62U;
    const auto difference = std::int64_t(std::uint64_t(now_ns) - std::uint64_t(h.sent_ns));
    return std::clamp(difference, -far_ns, far_ns);
  }

  /// False while the start before has not timed out.
  [[nodiscard]] bool is_new_start(const DatagramHeader& h, std::int64_t now_ns) noexcept SEXTANT_NONBLOCKING {
    if (h.generation == 0) return false;
    if (generation_ != 0) {
      if (now_ns - last_datagram_ns_ <= quiet_ns_) return false;
      ++counters_.restarts;
    }
    generation_ = h.generation;
    newest_ = h.sequence - 1;
    last_datagram_ns_ = now_ns;
    seen_ = ~std::uint64_t{0};
    followers_ = 0;
    fastest_known_ = false;
    return true;
  }

  /// True for the fourth number in a row out of reach.
  [[nodiscard]] bool goes_on(std::uint64_t sequence) noexcept SEXTANT_NONBLOCKING {
    constexpr int others = 3;
    followers_ = sequence == out_of_reach_ + 1 ? followers_ + 1 : 0;
    out_of_reach_ = sequence;
    return followers_ >= others;
  }

  [[nodiscard]] bool is_in_reach(std::uint64_t sequence,
                                 std::int64_t now_ns) const noexcept SEXTANT_NONBLOCKING {
    constexpr std::uint64_t burst = 64;
    const auto since_ns = std::uint64_t(std::max<std::int64_t>(0, now_ns - last_datagram_ns_));
    return sequence <= newest_ || sequence - newest_ <= burst + 2 * (since_ns / std::uint64_t(period_ns_));
  }

  /// `seen_` has a bit for each of the last 64 numbers, the newest at bit 0.
  void evaluate_order(std::uint64_t sequence) noexcept SEXTANT_NONBLOCKING {
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

  /// Compares with the fastest datagram; the two clocks may differ by 100 ppm in rate.
  void evaluate_transit(std::int64_t transit_ns, std::int64_t now_ns) noexcept SEXTANT_NONBLOCKING {
    if (!fastest_known_) {
      fastest_ns_ = transit_ns;
      fastest_known_ = true;
    }
    fastest_ns_ = std::min(fastest_ns_ + (now_ns - evaluated_ns_) / 10'000, transit_ns);
    evaluated_ns_ = now_ns;
    if (transit_ns > fastest_ns_ + 2 * period_ns_) ++counters_.late;
  }

  DatagramKind kind_;
  std::int64_t period_ns_;
  std::int64_t quiet_ns_;
  Counters counters_{};
  std::uint64_t newest_{0};
  std::uint64_t out_of_reach_{0};  // newest number that was
  int followers_{0};               // numbers in a row that were, after the first
  std::uint64_t seen_{0};
  std::int64_t last_datagram_ns_{0};
  std::int64_t evaluated_ns_{0};
  std::int64_t fastest_ns_{0};
  std::uint32_t generation_{0};
  bool fastest_known_{false};
};

}  // namespace sextant
