#include "ecu/parameters/parameter_changes.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace sextant::ecu {
namespace {

constexpr const char* at_rest =
    "only with the gates off and the machine without flux: disable the drive, let the flux decay, and set it "
    "again";

bool is_set(const std::string& key, const std::vector<std::string>& overrides) {
  return std::any_of(overrides.begin(), overrides.end(), [&key](const std::string& text) {
    return text.starts_with(key) && text.find_first_not_of(' ', key.size()) == text.find('=', key.size());
  });
}

/// The first key that changes no earlier than this.
const KeyChange* first_of(const std::vector<KeyChange>& changes, Changes when) {
  const auto found = std::find_if(changes.begin(), changes.end(),
                                  [when](const KeyChange& change) { return change.changes == when; });
  return found == changes.end() ? nullptr : &*found;
}

std::string shown(const std::string& value) {
  return value.empty() ? "not set" : value;
}

}  // namespace

std::string to_string(const std::vector<KeyChange>& changes) {
  std::string text;
  for (const KeyChange& change : changes) {
    text += fmt::format("{}{} from {} to {}", text.empty() ? "" : ", ", change.key, shown(change.from),
                        shown(change.to));
  }
  return text;
}

std::string not_at_rest(const std::vector<KeyChange>& changes) {
  if (const KeyChange* change = first_of(changes, Changes::when_ready))
    return fmt::format("{} changes {}", change->key, at_rest);
  return fmt::format("this control method takes parameters {}", at_rest);
}

ParameterChanges::ParameterChanges(const EcuConfig& running, Load load, SharedState& shared)
    : config_{running}, load_{std::move(load)}, shared_{shared} {}

bool ParameterChanges::offer(const std::vector<std::string>& overrides) {
  if (offered_ && outcome() == Outcome::waits)
    throw std::runtime_error{"the control thread has not taken the parameters before these yet"};
  require_same_file();
  offered_overrides_ = overrides_;
  offered_overrides_.insert(offered_overrides_.end(), overrides.begin(), overrides.end());
  offered_config_ = load_(offered_overrides_);
  changes_ = key_changes(config_, offered_config_);
  if (changes_.empty()) {
    overrides_ = offered_overrides_;  // a value that is its default now may not be one after another set
    return false;
  }
  offered_changes_ = when(overrides);
  offered_ = std::make_unique<ConfiguredDrive>(offered_config_.drive);
  if (!offered_->drive().takes_parameters()) offered_changes_ = Changes::when_ready;
  taken_before_ = shared_.parameter_sets.load(std::memory_order_acquire);
  shared_.parameters.store({++number_, offered_changes_, &offered_->drive()});
  return true;
}

ParameterChanges::Outcome ParameterChanges::outcome() {
  if (shared_.parameters_answered.load(std::memory_order_acquire) != number_) return Outcome::waits;
  const bool taken = shared_.parameter_sets.load(std::memory_order_acquire) != taken_before_;
  if (!offered_) return taken ? Outcome::taken : Outcome::refused;
  if (taken) {
    config_ = offered_config_;
    overrides_ = offered_overrides_;
    if (offered_changes_ == Changes::when_ready) std::swap(running_, offered_);
  }
  offered_.reset();
  return taken ? Outcome::taken : Outcome::refused;
}

/// The file may have been written since the drive was started.
void ParameterChanges::require_same_file() const {
  const std::vector<KeyChange> other = key_changes(config_, load_(overrides_));
  if (other.empty()) return;
  throw std::runtime_error{fmt::format(
      "the configuration file is another one than at the start ({}): restore it, or start the drive anew",
      to_string({other.front()}))};
}

Changes ParameterChanges::when(const std::vector<std::string>& overrides) const {
  if (const KeyChange* change = first_of(changes_, Changes::never)) {
    throw std::runtime_error{
        fmt::format("{} never changes while the drive runs{}: start it anew with --set", change->key,
                    is_set(change->key, overrides) ? "" : ", and follows from what is set")};
  }
  return first_of(changes_, Changes::when_ready) != nullptr ? Changes::when_ready : Changes::always;
}

}  // namespace sextant::ecu
