#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sextant/core/torque_command.hpp"

namespace sextant {

/// The E2E check state machine of one protected message (AUTOSAR FO PRS E2EProtocol, E2E state machine), over
/// a sliding window of the last results.
///
///   NODATA  → INIT     first frame that is not an error
///   INIT    → VALID    enough OK, no error too many
///   INIT    → INVALID  as VALID → INVALID
///   VALID   → INVALID  too many errors in the window
///   INVALID → VALID    enough OK, no error too many
///
/// Frames that are neither OK nor errors take a place in the window.
class E2eStateMachine {
 public:
  enum class Status : std::uint8_t { none, ok, error, neutral };

  static constexpr std::size_t window_capacity = 32;

  struct Parameters {
    std::uint8_t window{10};            ///< results that count [-]
    std::uint8_t min_ok_init{3};        ///< OK needed, INIT → VALID [-]
    std::uint8_t max_error_init{0};     ///< errors allowed, INIT → VALID [-]
    std::uint8_t max_error_valid{2};    ///< errors allowed before INVALID [-]
    std::uint8_t min_ok_invalid{5};     ///< OK needed, INVALID → VALID [-]
    std::uint8_t max_error_invalid{0};  ///< errors allowed, INVALID → VALID [-]

    [[nodiscard]] constexpr const char* validate() const noexcept {
      if (window < 1 || window > window_capacity) return "window must be from 1 to 32";
      if (min_ok_init > window || min_ok_invalid > window) return "the OK counts must fit into the window";
      return nullptr;
    }
  };

  constexpr E2eStateMachine() noexcept : E2eStateMachine(Parameters{}) {}
  explicit constexpr E2eStateMachine(const Parameters& parameters) noexcept : parameters_(parameters) {}

  constexpr void add(Status status) noexcept {
    results_[next_] = status;
    next_ = (next_ + 1) % parameters_.window;
    const int ok = count(Status::ok);
    const int errors = count(Status::error);
    switch (state_) {
      case E2eState::no_data:
        if (status != Status::error) state_ = E2eState::init;
        break;
      case E2eState::init:
        if (ok >= parameters_.min_ok_init && errors <= parameters_.max_error_init) {
          state_ = E2eState::valid;
        } else if (errors > parameters_.max_error_valid) {
          state_ = E2eState::invalid;
        }
        break;
      case E2eState::valid:
        if (errors > parameters_.max_error_valid) state_ = E2eState::invalid;
        break;
      case E2eState::invalid:
        if (ok >= parameters_.min_ok_invalid && errors <= parameters_.max_error_invalid) {
          state_ = E2eState::valid;
        }
        break;
    }
  }

  [[nodiscard]] constexpr E2eState state() const noexcept { return state_; }

 private:
  [[nodiscard]] constexpr int count(Status status) const noexcept {
    int n = 0;
    for (std::size_t i = 0; i < parameters_.window; ++i) n += results_[i] == status ? 1 : 0;
    return n;
  }

  Parameters parameters_;
  std::array<Status, window_capacity> results_{};
  std::size_t next_{0};
  E2eState state_{E2eState::no_data};
};

}  // namespace sextant
