#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include <sys/types.h>

#include "ecu/telemetry/publisher_watch.hpp"
#include "ecu/telemetry/telemetry_sender.hpp"
#include "sextant/comms/telemetry_messages.hpp"

namespace sextant::ecu {

/// `sextant-telemetry`, the process in which DDS runs. This class starts it, sends samples through a
/// TelemetrySender, and restarts it after its end. One that has stopped, by PublisherWatch, it kills. The two
/// processes share no memory, and the drive never waits for the publisher while it runs: no failure of it, or
/// of a library in it, affects the drive.
///
/// The drive keeps the publisher's end of the connection open too: what a process has not received before its
/// end is still in it, and is counted as dropped.
///
/// After a crash the process is restarted without type information: Cyclone DDS 0.10.2 crashes when it
/// fetches the type of a reader that declares a topic with an int8 or uint8.
class TelemetryProcess {
 public:
  struct Parameters {
    std::string program{};  ///< file; empty: sextant-telemetry beside the running program, or on PATH
    std::uint32_t domain_id{0};
    std::uint32_t drive_id{1};
    std::string configuration{};         ///< as in DdsTelemetry::Parameters
    std::string configuration_source{};  ///< the same
  };

  /// Starts the process and waits until DDS runs in it. Throws std::runtime_error with one sentence where one
  /// of them fails.
  explicit TelemetryProcess(const Parameters& parameters);
  TelemetryProcess(const TelemetryProcess&) = delete;
  TelemetryProcess& operator=(const TelemetryProcess&) = delete;
  ~TelemetryProcess();

  [[nodiscard]] TelemetrySender& sender() noexcept { return sender_; }
  [[nodiscard]] const TelemetrySender& sender() const noexcept { return sender_; }

  /// Receives the messages of the process, kills it when it has stopped, restarts it some time after its end,
  /// and logs all three. Never waits.
  void poll(std::int64_t now_ns);

  /// Ends the process after it has published what was sent; kills it after a timeout. Safe to call twice.
  void leave();

  /// Counts of all processes together.
  [[nodiscard]] CountsMessage counts() const noexcept;
  /// Restarts of the process. [-]
  [[nodiscard]] std::uint64_t restarts() const noexcept { return restarts_; }

 private:
  static constexpr std::int64_t first_delay_ns = 100'000'000;   ///< before the first restart [ns]
  static constexpr std::int64_t last_delay_ns = 5'000'000'000;  ///< each delay is twice the one before [ns]
  static constexpr std::int64_t healthy_ns =
      10'000'000'000;  ///< run time after which the first delay applies again [ns]
  /// Time in which a restarted process finds the readers that there are [ns].
  static constexpr std::int64_t rediscovery_ns = 1'000'000'000;
  static constexpr int ready_within_ms = 60'000;  ///< at start [ms]
  static constexpr int left_within_ms = 1000;     ///< [ms]

  void start();
  [[nodiscard]] pid_t spawn(int descriptor) const;
  void wait_until_ready();
  void receive_messages();
  void handle(std::span<const std::byte> message);
  [[nodiscard]] bool reaped();
  void kill_stopped();
  /// After the end of the process: closes the connection and counts what is left in it.
  void close_connection();
  void schedule_restart(std::int64_t now_ns);
  void restart(std::int64_t now_ns);

  Parameters parameters_;
  TelemetrySender sender_{};
  MessageSocket its_end_{};  // the publisher's end of the connection
  PublisherWatch watch_{};
  pid_t pid_{0};   // 0: none
  int status_{0};  // of waitpid, of the last one that ended
  bool ready_{false};
  bool killed_{false};  // it has stopped
  bool type_information_{true};
  std::string refusal_{};
  CountsMessage counts_{};   // of this process
  CountsMessage earlier_{};  // of those before it
  std::uint64_t restarts_{0};
  std::int64_t started_ns_{0};
  std::int64_t delay_ns_{first_delay_ns};  // of the next restart
  std::int64_t restart_ns_{0};             // when to start it again
};

}  // namespace sextant::ecu
