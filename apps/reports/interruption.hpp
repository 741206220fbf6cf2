#pragma once

#include <array>
#include <csignal>

#include "sextant/run/verdict.hpp"

namespace sextant::reports {

/// The first SIGINT or SIGTERM ends a run in order; the next one of either ends the program at once.
class Interruption {
 public:
  Interruption() {
    struct sigaction action{};
    action.sa_handler = [](int signal) {
      caught = signal;
      restore_defaults();
    };
    for (const int signal : ending) sigaddset(&action.sa_mask, signal);
    for (const int signal : ending) sigaction(signal, &action, nullptr);
  }

  /// The signal that has come; 0 while none has.
  [[nodiscard]] int signal() const noexcept { return caught; }

  /// Exit status of a program that a signal has ended, as shells count.
  [[nodiscard]] int status() const noexcept { return exit_status(Verdict::interrupted) + caught; }

 private:
  static constexpr std::array ending{SIGINT, SIGTERM};

  static void restore_defaults() {
    struct sigaction action{};
    action.sa_handler = SIG_DFL;
    for (const int signal : ending) sigaction(signal, &action, nullptr);
  }

  static inline volatile std::sig_atomic_t caught = 0;
};

}  // namespace sextant::reports
