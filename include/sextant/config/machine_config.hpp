#pragma once

#include <functional>
#include <optional>
#include <string>

#include "sextant/config/schema.hpp"
#include "sextant/core/induction_machine_parameters.hpp"
#include "sextant/core/machine_circuits.hpp"

namespace sextant {

/// A machine by its data sheet. Keys that are not set keep the value before, so that the same keys describe a
/// machine or change one.
struct MachineConfig {
  std::optional<MachineCircuit> circuit{};  ///< whose elements inductances and rotor resistance are
  std::optional<double> r_s_ohm{};
  std::optional<double> r_r_ohm{};
  std::optional<double> x_ls_ohm{};  ///< each reactance, or the inductance below
  std::optional<double> x_lr_ohm{};
  std::optional<double> x_sigma_ohm{};  ///< in the place of both where all leakage is in one
  std::optional<double> x_m_ohm{};
  std::optional<double> reactance_frequency_hz{};  ///< at which the reactances hold [Hz]
  std::optional<double> l_ls_h{};
  std::optional<double> l_lr_h{};
  std::optional<double> l_sigma_h{};
  std::optional<double> l_m_h{};
  std::optional<int> poles{};  ///< twice the pole pairs [-]
  std::optional<double> inertia_kg_m2{};

  [[nodiscard]] bool has_reactance() const noexcept { return x_ls_ohm || x_lr_ohm || x_sigma_ohm || x_m_ohm; }

  /// Empty when usable, else what is wrong.
  [[nodiscard]] std::string validate() const;
};

/// The keys of a complete machine, each of which must be set.
void describe(Section section, MachineConfig& config);

/// The keys of a machine that differs from `machine` in those that are set. unset: what counts for the
/// others; circuit: of which circuit the keys are unless they say so.
void describe_changes(Section section, MachineConfig& config, const MachineConfig& machine,
                      const std::string& unset, const std::function<MachineCircuit()>& circuit);

/// `machine` with the values that `config` sets, as a T circuit; where they are those of another circuit,
/// with equal leakage inductances (`from_gamma`). Reactances without a frequency of their own hold at
/// `reactance_frequency_hz` [Hz]; `circuit` is theirs unless `config` says so.
[[nodiscard]] InductionMachineParameters<> apply(const MachineConfig& config,
                                                 InductionMachineParameters<> machine,
                                                 double reactance_frequency_hz,
                                                 MachineCircuit circuit = MachineCircuit::t);

}  // namespace sextant
