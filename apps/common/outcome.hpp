#pragma once

#include <exception>
#include <optional>

namespace sextant {

/// What work has come to: its result, or what it threw.
template <class Result>
struct Outcome {
  std::optional<Result> result{};
  std::exception_ptr problem{};
};

/// Works, and keeps what comes of it.
template <class Work>
[[nodiscard]] auto outcome_of(const Work& work) -> Outcome<decltype(work())> {
  try {
    return {.result = work()};
  } catch (...) {
    return {.problem = std::current_exception()};
  }
}

}  // namespace sextant
