#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>

#include "sextant/comms/can_codec.hpp"
#include "sextant/comms/e2e_profile11.hpp"
#include "sextant/virtual_time/virtual_can_bus.hpp"
#include "sextant/virtual_time/virtual_timeline.hpp"

namespace sextant {

/// A vehicle control unit in virtual time. It sends commands on a fixed grid, with counter and CRC, and
/// listens to MCU_TorqueStatus: disable until the drive is ready, enable with torque, and disable again at
/// the end.
class VirtualVehicle {
 public:
  struct Parameters {
    std::int64_t first_ns{0};              ///< when it sends its first frame [ns]
    std::int64_t period_ns{10'000'000};    ///< between two frames [ns]
    std::int64_t enable_from_ns{0};        ///< earliest time of its first enable after a hand-shake [ns]
    double torque_limit{250.0};            ///< magnitude that it allows the drive [N·m]
    bool hand_shake{true};                 ///< false: it enables with its first frame
    bool clear_faults{false};              ///< send a fault reset to a drive in FAULT, and start again
    int closing_frames{10};                ///< disables after the last torque [-]
    std::uint8_t first_counter{0};         ///< E2E counter of its first frame, 0…14 [-]
    IdentifierOffset identifier_offset{};  ///< of its drive

    [[nodiscard]] const char* validate() const noexcept {
      if (period_ns <= 0) return "the period of a vehicle's commands must be above zero";
      if (closing_frames < 0) return "a vehicle cannot send less than no frame";
      if (first_counter >= e2e::counter_modulus) return "an E2E counter is from 0 to 14";
      return identifier_offset.validate();
    }
  };
  enum class Phase : std::uint8_t { waiting, driving, resetting, closing, done };

  /// Torque over the time since the first enable [ns], signed [N·m].
  using Torque = std::function<double(std::int64_t since_ns)>;

  /// Drives for duration_ns; `never_ns`: without end. Clock and bus are not owned and must outlive this
  /// object, which must stay where it is. Throws std::invalid_argument with the sentence of `validate()`.
  VirtualVehicle(const Parameters& parameters, const VirtualClock& clock, VirtualCanBus& bus, Torque torque,
                 std::int64_t duration_ns = never_ns);
  VirtualVehicle(const VirtualVehicle&) = delete;
  VirtualVehicle& operator=(const VirtualVehicle&) = delete;

  [[nodiscard]] VirtualParty party();
  [[nodiscard]] Phase phase() const noexcept { return phase_; }
  /// When the first enable went out; empty before. [ns]
  [[nodiscard]] std::optional<std::int64_t> enabled_ns() const noexcept { return enabled_ns_; }
  /// The newest status of the drive; empty before.
  [[nodiscard]] const std::optional<TorqueStatus>& status() const noexcept { return status_; }

  /// Pauses sending, or resumes it at the next due time. The counter continues from the last frame sent.
  void pause_sending(bool paused) noexcept { paused_ = paused; }
  /// Freezes the counter, or resumes it.
  void freeze_counter(bool frozen) noexcept { frozen_ = frozen; }
  /// Changes the payload of every frame before it is protected, as a faulty vehicle would;
  /// an empty function ends it.
  void tamper(std::function<void(e2e::Data& payload)> with) { tamper_ = std::move(with); }
  /// The counter jumps ahead by so much.
  void skip_counters(unsigned n) noexcept;

 private:
  void act();
  void choose_phase();
  void send(const TorqueCommand<double>& command);
  void hear(const CanFrame& frame);
  [[nodiscard]] bool drive_is_ready() const noexcept;
  [[nodiscard]] bool drive_has_tripped() const noexcept;

  Parameters parameters_;
  const VirtualClock& clock_;
  VirtualCanBus& bus_;
  Torque torque_;
  std::int64_t duration_ns_;
  std::int64_t next_ns_;
  Phase phase_;
  std::uint8_t counter_;
  E2eChecker checker_;
  std::optional<TorqueStatus> status_{};
  std::optional<std::int64_t> enabled_ns_{};
  std::function<void(e2e::Data&)> tamper_{};
  int closing_sent_{0};
  bool paused_{false};
  bool frozen_{false};
};

}  // namespace sextant
