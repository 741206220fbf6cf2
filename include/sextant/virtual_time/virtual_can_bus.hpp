#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <utility>
#include <vector>

#include "sextant/comms/can_bus.hpp"
#include "sextant/virtual_time/bus_event.hpp"
#include "sextant/virtual_time/virtual_clock.hpp"
#include "sextant/virtual_time/virtual_timeline.hpp"

namespace sextant {

/// A CAN bus in virtual time: the drive uses the `CanBus` seam, all other nodes use `put` and `listen`. A
/// frame arrives at the instant at which it was put, unless a `BusEvent` changes that; of
/// frames that arrive at one instant the first to be put is the first to be read. There is no arbitration, no
/// bit timing and no limit of load.
///
/// Everything happens on the thread that runs the timeline, and nothing ever waits: time is moved by the
/// timeline alone, so `receive` ignores its `timeout`.
class VirtualCanBus final : public CanBus {
 public:
  /// Counts of the frames that other nodes put on the bus.
  struct Counts {
    std::uint64_t put{};        ///< by `put` and by inserting events [-]
    std::uint64_t lost{};       ///< one by one, or because the bus or the interface was away [-]
    std::uint64_t corrupted{};  ///< [-]
    std::uint64_t delayed{};    ///< by `delay`, `reorder` or `burst` [-]
    std::uint64_t doubled{};    ///< [-]
  };
  using Listener = std::function<void(const CanFrame& frame)>;

  /// The clock is not owned. Throws std::invalid_argument with the number of an event, from 0, that is not
  /// valid.
  explicit VirtualCanBus(const VirtualClock& clock, const std::vector<BusEvent>& events = {});

  /// Adds an event; one whose beginning has passed begins now. Throws as the constructor.
  void add(const BusEvent& event);

  /// Another node sends a frame now. Its arrival time is set here.
  void put(const CanFrame& frame);

  /// Calls `listener` with every frame that the drive sends, at the instant at which it does.
  void listen(Listener listener) { listeners_.push_back(std::move(listener)); }

  /// Calls `watcher` with every frame that passes the drive's interface, sent or received, in order of time:
  /// what candump would show there.
  void watch(Listener watcher) { watchers_.push_back(std::move(watcher)); }

  [[nodiscard]] CanSend send(const CanFrame& frame) noexcept override;
  [[nodiscard]] CanReceive receive(CanFrame& frame, std::chrono::nanoseconds timeout) noexcept override;
  [[nodiscard]] CanBusStats stats() const noexcept override { return stats_; }
  [[nodiscard]] const Counts& counts() const noexcept { return counts_; }

  /// When the next unread frame arrives; `never_ns` while there is none or the
  /// interface is down. [ns]
  [[nodiscard]] std::int64_t next_arrival_ns() const noexcept;

  /// The bus as a party of a timeline: its events begin and end in time.
  [[nodiscard]] VirtualParty party();

 private:
  struct Armed {
    BusEvent event;
    std::uint32_t used{0};
    bool begun{false};
    bool ended{false};

    [[nodiscard]] bool holds(std::int64_t now_ns) const noexcept {
      return event.begin_ns <= now_ns && now_ns < event.end_ns;
    }
  };
  struct Arrival {
    std::int64_t t_ns;
    CanFrame frame;
  };

  [[nodiscard]] std::int64_t next_event_ns() const noexcept;
  void update();
  void begin(const BusEvent& event);
  void end(const BusEvent& event);
  [[nodiscard]] bool in_force(BusEventKind kind) const noexcept;
  [[nodiscard]] const BusEvent* take(BusEventKind kind) noexcept;
  void deliver(CanFrame frame);
  void queue(const CanFrame& frame, std::int64_t arrival_ns);
  void release_held();
  void lose_what_is_on_the_way();

  const VirtualClock& clock_;
  std::vector<Armed> events_{};  // by their beginnings
  std::size_t first_live_{0};    // all before it have ended
  std::uint32_t added_{0};
  std::deque<Arrival> arrivals_{};  // in order of arrival
  std::vector<CanFrame> held_{};    // that wait for the next one to overtake
  std::vector<Listener> listeners_{};
  std::vector<Listener> watchers_{};
  CanBusStats stats_{};
  Counts counts_{};
};

}  // namespace sextant
