#include "telemetry/publisher.hpp"

#include <cstddef>
#include <utility>

#include <unistd.h>

#include "common/exit_status.hpp"

namespace sextant {
namespace {

constexpr std::size_t longest_message = sizeof(WaveformMessage) + (1 << 12);
constexpr std::chrono::nanoseconds reports_every{publisher_reports_every_ns};

}  // namespace

Publisher::Publisher(std::vector<MessageSocket> sockets) : buffer_(longest_message) {
  for (MessageSocket& socket : sockets) drives_.emplace_back(std::move(socket));
}

int Publisher::run() {
  alarm(publisher_hang_limit_s);
  if (!start()) return ExitStatus::refused;
  publish();
  return ExitStatus::done;
}

bool Publisher::start() {
  for (PublishedDrive& drive : drives_) {
    if (!drive.start(drives_.front())) return false;
  }
  for (PublishedDrive& drive : drives_) drive.say_ready();
  return true;
}

void Publisher::publish() {
  while (!drives_.empty()) {
    report_when_due();
    wait();
    // Also while messages arrive faster than they are published.
    while (publish_next()) report_when_due();
  }
}

void Publisher::wait() {
  std::vector<const MessageSocket*> sockets;
  sockets.reserve(drives_.size());
  for (const PublishedDrive& drive : drives_) sockets.push_back(&drive.socket());
  (void)MessageSocket::wait_any(sockets,
                                std::chrono::duration_cast<std::chrono::milliseconds>(reports_every));
}

bool Publisher::publish_next() {
  bool any = false;
  for (PublishedDrive& drive : drives_) {
    any |= drive.publish(buffer_);
    if (drive.is_over()) drive.report_counts();
  }
  std::erase_if(drives_, [](const PublishedDrive& drive) { return drive.is_over(); });
  return any;
}

void Publisher::report_when_due() {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_report_) return;
  next_report_ = now + reports_every;
  alarm(publisher_hang_limit_s);
  for (PublishedDrive& drive : drives_) drive.report_counts();
}

}  // namespace sextant
