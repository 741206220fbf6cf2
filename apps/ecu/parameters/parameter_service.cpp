#include "ecu/parameters/parameter_service.hpp"

#include <chrono>
#include <exception>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "common/request_text.hpp"
#include "ecu/unit/contract_fit.hpp"
#include "sextant/config/load_config.hpp"
#include "sextant/realtime/monotonic_clock.hpp"

namespace sextant::ecu {

ParameterService::ParameterService(const std::string& socket, ParameterChanges& changes,
                                   std::string log_prefix)
    : changes_{changes},
      log_prefix_{std::move(log_prefix)},
      socket_{socket, [this](const std::string& request) { return answer(request); }} {}

std::string ParameterService::answer(const std::string& request) {
  try {
    if (waits_) (void)outcome();
    if (request == "describe") return running_keys(changes_.config());
    waits_ = changes_.offer(request_lines(request));
    return waits_ ? outcome_of_offer() : "ok";
  } catch (const std::exception& problem) {
    return problem_text(problem);
  }
}

std::string ParameterService::outcome_of_offer() {
  using namespace std::chrono_literals;
  using Outcome = ParameterChanges::Outcome;
  Outcome found = outcome();
  for (int k = 0; found == Outcome::waits && k < 200; ++k) {
    std::this_thread::sleep_for(1ms);
    found = outcome();
  }
  if (found == Outcome::refused) return not_at_rest(changes_.changes());
  if (found == Outcome::waits)
    return "the control thread has not answered within 200 ms, and takes it when it does: list the values "
           "then";
  std::string reply = "ok";
  for (const KeyChange& change : changes_.changes()) reply += "\n" + to_string(std::vector{change});
  return reply;
}

ParameterChanges::Outcome ParameterService::outcome() {
  const ParameterChanges::Outcome found = changes_.outcome();
  waits_ = found == ParameterChanges::Outcome::waits;
  if (found != ParameterChanges::Outcome::taken) return found;
  spdlog::info("{}parameters {} at {:.6f} s: {}", log_prefix_, changes_.number(), double(now_ns()) * 1e-9,
               to_string(changes_.changes()));
  if (const std::string beyond = beyond_contract(changes_.config().drive); !beyond.empty())
    spdlog::warn("{}CAN: {}", log_prefix_, beyond);
  return found;
}

}  // namespace sextant::ecu
