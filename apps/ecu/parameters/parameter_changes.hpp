#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "ecu/shared/shared_state.hpp"
#include "ecu/unit/configured_drive.hpp"
#include "sextant/config/ecu_config.hpp"
#include "sextant/config/key_change.hpp"

namespace sextant::ecu {

/// Changes the parameters of the running drive. A change is read, checked and resolved as the file is, by the
/// same function, with the changed keys as further overrides; every value that becomes another one, derived
/// ones included, must be one that may change now (`Changes`). A drive is built with the new parameters, of
/// which the control thread takes what it needs, or which takes the place of the running one, at the
/// beginning of a control period. For one thread, which is not the control thread.
class ParameterChanges {
 public:
  /// The configuration of the program with these overrides behind its own. Throws ConfigError.
  using Load = std::function<EcuConfig(const std::vector<std::string>& overrides)>;

  enum class Outcome : std::uint8_t {
    waits,   ///< the control thread has not come to it yet
    taken,   ///< from the last control period on
    refused  ///< the drive was not at rest
  };

  /// running: the configuration that the drive runs with. The shared state must outlive this object.
  ParameterChanges(const EcuConfig& running, Load load, SharedState& shared);

  /// Offers the running drive these keys, `key=value` as after --set; false where no value becomes another
  /// one. Throws std::runtime_error with the sentences of what is wrong.
  [[nodiscard]] bool offer(const std::vector<std::string>& overrides);

  /// What has become of the offer. To be called until it does not wait.
  [[nodiscard]] Outcome outcome();

  /// What the running drive runs with.
  [[nodiscard]] const EcuConfig& config() const noexcept { return config_; }
  /// Number of the last offer [-], and what it changes.
  [[nodiscard]] std::uint64_t number() const noexcept { return number_; }
  [[nodiscard]] const std::vector<KeyChange>& changes() const noexcept { return changes_; }

 private:
  void require_same_file() const;
  [[nodiscard]] Changes when(const std::vector<std::string>& overrides) const;

  EcuConfig config_;
  Load load_;
  SharedState& shared_;
  std::vector<std::string> overrides_{};  ///< taken so far

  std::uint64_t number_{0};
  std::uint64_t taken_before_{0};  ///< sets that had been taken at the last offer [-]
  std::vector<std::string> offered_overrides_{};
  std::vector<KeyChange> changes_{};
  EcuConfig offered_config_{};
  Changes offered_changes_{Changes::never};
  std::unique_ptr<ConfiguredDrive> offered_{};  ///< until there is an outcome
  std::unique_ptr<ConfiguredDrive> running_{};  ///< that has taken the place of the first one, if one has
};

/// The changes of a set for people: `KEY from FROM to TO`, by commas.
[[nodiscard]] std::string to_string(const std::vector<KeyChange>& changes);

/// Why the drive has not taken a set that waits for rest.
[[nodiscard]] std::string not_at_rest(const std::vector<KeyChange>& changes);

}  // namespace sextant::ecu
