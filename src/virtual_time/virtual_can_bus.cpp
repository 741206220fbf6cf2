#include "sextant/virtual_time/virtual_can_bus.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace sextant {

VirtualCanBus::VirtualCanBus(const VirtualClock& clock, const std::vector<BusEvent>& events) : clock_{clock} {
  for (const BusEvent& event : events) add(event);
}

void VirtualCanBus::add(const BusEvent& event) {
  if (const char* problem = event.validate()) {
    throw std::invalid_argument{"bus event " + std::to_string(added_) + " (" + to_string(event.kind) +
                                "): " + problem};
  }
  ++added_;
  const auto place =
      std::ranges::upper_bound(events_, event.begin_ns, {}, [](const Armed& x) { return x.event.begin_ns; });
  first_live_ = std::min(first_live_, std::size_t(place - events_.begin()));
  events_.insert(place, {.event = event});
}

VirtualParty VirtualCanBus::party() {
  return {.next_due_ns = [this] { return next_event_ns(); }, .act = [this] { update(); }};
}

std::int64_t VirtualCanBus::next_event_ns() const noexcept {
  std::int64_t next = never_ns;
  for (std::size_t k = first_live_; k < events_.size(); ++k) {
    const Armed& armed = events_[k];
    if (!armed.ended) next = std::min(next, armed.begun ? armed.event.end_ns : armed.event.begin_ns);
    // Those behind it begin later still.
    if (!armed.begun) break;
  }
  return next;
}

void VirtualCanBus::update() {
  const std::int64_t now = clock_.now_ns();
  for (std::size_t k = first_live_; k < events_.size() && events_[k].event.begin_ns <= now; ++k) {
    Armed& armed = events_[k];
    if (!armed.begun) {
      armed.begun = true;
      armed.ended = armed.event.kind == BusEventKind::insert;
      begin(armed.event);
    }
    if (!armed.ended && armed.event.end_ns <= now) {
      armed.ended = true;
      end(armed.event);
    }
  }
  while (first_live_ < events_.size() && events_[first_live_].ended) ++first_live_;
}

void VirtualCanBus::begin(const BusEvent& event) {
  switch (event.kind) {
    case BusEventKind::insert:
      put(event.frame);
      return;
    case BusEventKind::bus_off:
      lose_what_is_on_the_way();
      queue({.id = can_error_bus_off, .error = true, .length = 8}, clock_.now_ns());
      return;
    case BusEventKind::interface_down:
      lose_what_is_on_the_way();
      return;
    default:
      return;
  }
}

void VirtualCanBus::end(const BusEvent& event) {
  if (event.kind == BusEventKind::interface_down && !in_force(event.kind)) ++stats_.reopened;
  // Nothing overtook them: they arrive all the same.
  if (event.kind == BusEventKind::reorder) release_held();
}

void VirtualCanBus::lose_what_is_on_the_way() {
  counts_.lost += arrivals_.size() + held_.size();
  arrivals_.clear();
  held_.clear();
}

bool VirtualCanBus::in_force(BusEventKind kind) const noexcept {
  const std::int64_t now = clock_.now_ns();
  for (std::size_t k = first_live_; k < events_.size() && events_[k].event.begin_ns <= now; ++k) {
    if (events_[k].event.kind == kind && events_[k].holds(now)) return true;
  }
  return false;
}

const BusEvent* VirtualCanBus::take(BusEventKind kind) noexcept {
  const std::int64_t now = clock_.now_ns();
  for (std::size_t k = first_live_; k < events_.size() && events_[k].event.begin_ns <= now; ++k) {
    Armed& armed = events_[k];
    if (armed.event.kind != kind || !armed.holds(now)) continue;
    if (armed.event.count != 0 && armed.used >= armed.event.count) continue;
    ++armed.used;
    return &armed.event;
  }
  return nullptr;
}

void VirtualCanBus::put(const CanFrame& frame) {
  ++counts_.put;
  const bool away = in_force(BusEventKind::bus_off) || in_force(BusEventKind::interface_down);
  if (away || take(BusEventKind::lose) != nullptr) {
    ++counts_.lost;
    return;
  }
  CanFrame seen = frame;
  if (const BusEvent* const event = take(BusEventKind::corrupt)) {
    seen.data[event->byte] ^= event->mask;
    ++counts_.corrupted;
  }
  if (take(BusEventKind::reorder) != nullptr) {
    held_.push_back(seen);
    ++counts_.delayed;
    return;
  }
  deliver(seen);
  release_held();
}

void VirtualCanBus::deliver(CanFrame frame) {
  std::int64_t arrival_ns = clock_.now_ns();
  if (const BusEvent* const event = take(BusEventKind::burst)) {
    arrival_ns = event->end_ns;
    ++counts_.delayed;
  }
  if (const BusEvent* const event = take(BusEventKind::delay)) {
    arrival_ns += event->delay_ns;
    ++counts_.delayed;
  }
  queue(frame, arrival_ns);
  if (const BusEvent* const event = take(BusEventKind::duplicate)) {
    queue(frame, arrival_ns + event->delay_ns);
    ++counts_.doubled;
  }
}

void VirtualCanBus::release_held() {
  for (const CanFrame& frame : std::exchange(held_, {})) queue(frame, clock_.now_ns());
}

void VirtualCanBus::queue(const CanFrame& frame, std::int64_t arrival_ns) {
  if (in_force(BusEventKind::interface_down)) {
    ++counts_.lost;
    return;
  }
  const auto place =
      std::ranges::upper_bound(arrivals_, arrival_ns, {}, [](const Arrival& x) { return x.t_ns; });
  Arrival& arrival = *arrivals_.insert(place, {arrival_ns, frame});
  arrival.frame.received_ns = arrival_ns;
}

CanSend VirtualCanBus::send(const CanFrame& frame) noexcept {
  const bool down = in_force(BusEventKind::interface_down);
  // A controller that is off the bus sends nothing, so that its queue fills.
  if (down || in_force(BusEventKind::bus_off) || in_force(BusEventKind::refuse_transmit)) {
    ++stats_.send_dropped;
    return down ? CanSend::down : CanSend::no_buffer;
  }
  ++stats_.sent;
  CanFrame stamped = frame;
  stamped.received_ns = clock_.now_ns();
  for (const Listener& listener : listeners_) listener(stamped);
  for (const Listener& watcher : watchers_) watcher(stamped);
  return CanSend::ok;
}

std::int64_t VirtualCanBus::next_arrival_ns() const noexcept {
  // Frames in transit are lost, even before the party of the event has run.
  if (arrivals_.empty() || in_force(BusEventKind::interface_down)) return never_ns;
  return arrivals_.front().t_ns;
}

CanReceive VirtualCanBus::receive(CanFrame& frame, std::chrono::nanoseconds) noexcept {
  if (in_force(BusEventKind::interface_down)) return CanReceive::down;
  if (next_arrival_ns() > clock_.now_ns()) return CanReceive::timeout;
  frame = arrivals_.front().frame;
  arrivals_.pop_front();
  ++stats_.received;
  if (frame.error) ++stats_.error_frames;
  if (frame.error && (frame.id & can_error_bus_off) != 0) ++stats_.bus_off;
  for (const Listener& watcher : watchers_) watcher(frame);
  return CanReceive::got;
}

}  // namespace sextant
