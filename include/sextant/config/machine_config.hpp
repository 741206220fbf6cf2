#pragma once

#include <optional>
#include <string>

#include "sextant/config/schema.hpp"
#include "sextant/core/induction_machine_parameters.hpp"

namespace sextant {

/// A machine by its data sheet. Keys that are not set keep the value before, so that the same keys describe a
/// machine or change one.
struct MachineConfig {
  std::optional<double> r_s_ohm{};
  std::optional<double> r_r_ohm{};
  std::optional<double> x_ls_ohm{};  ///< each reactance, or the inductance below
  std::optional<double> x_lr_ohm{};
  std::optional<double> x_m_ohm{};
  std::optional<double> reactance_frequency_hz{};  ///< at which the reactances hold [Hz]
  std::optional<double> l_ls_h{};
  std::optional<double> l_lr_h{};
  std::optional<double> l_m_h{};
  std::optional<int> poles{};  ///< twice the pole pairs [-]
  std::optional<double> inertia_kg_m2{};

  [[nodiscard]] bool has_reactance() const noexcept { return x_ls_ohm || x_lr_ohm || x_m_ohm; }

  /// Empty when usable, else what is wrong.
  [[nodiscard]] std::string validate() const;
};

/// The keys of a machine. Where `unset` is empty every quantity must be set; else it says what counts for one
/// that is not.
void describe(Section section, MachineConfig& config, const std::string& unset = {});

/// `machine` with the values that `config` sets. Reactances without a frequency of their own hold at
/// `reactance_frequency_hz` [Hz].
[[nodiscard]] InductionMachineParameters<> apply(const MachineConfig& config,
                                                 InductionMachineParameters<> machine,
                                                 double reactance_frequency_hz);

}  // namespace sextant
