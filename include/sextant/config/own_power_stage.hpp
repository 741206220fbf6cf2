#pragma once

#include <memory>

#include "sextant/config/cloned.hpp"
#include "sextant/config/schema.hpp"
#include "sextant/core/drive_basis.hpp"
#include "sextant/core/drive_io.hpp"

namespace sextant {

/// A power stage that a program brings, as files choose and describe it: `power_stage = "NAME"` and the table
/// `[NAME]`. It holds the parameters of its `DriveIo`; `own_power_stage` makes one of the class of that.
class OwnPowerStage {
 public:
  virtual ~OwnPowerStage() = default;

  /// Of the power stage and its table.
  [[nodiscard]] virtual const char* name() const noexcept = 0;
  /// One line for the reader of the file.
  [[nodiscard]] virtual const char* meaning() const noexcept = 0;
  /// Its time is that of `read()` alone, as that of a model, so that it can run in virtual time.
  [[nodiscard]] virtual bool waits_for_drive() const noexcept = 0;
  /// Describes the table. Parameters and `basis` are bound by reference.
  virtual void describe_table(Section table, const DriveBasis<double>& basis) = 0;
  /// Opens the power stage with these parameters. Throws std::runtime_error with one sentence where it cannot
  /// be opened.
  [[nodiscard]] virtual std::unique_ptr<DriveIo<double>> open() const = 0;
  /// The same with the same parameters.
  [[nodiscard]] virtual std::unique_ptr<OwnPowerStage> clone() const = 0;
  /// The same with the parameters before a file has been read.
  [[nodiscard]] virtual std::unique_ptr<OwnPowerStage> untouched() const = 0;

 protected:
  OwnPowerStage() = default;
  OwnPowerStage(const OwnPowerStage&) = default;
  OwnPowerStage& operator=(const OwnPowerStage&) = default;
};

/// The power stage of class `Io`, a `DriveIo<double>`, or a `SupervisedDriveIo<double>` where other threads
/// have to turn its gates off, with
/// - `static constexpr const char* name, meaning;`, as above
/// - `static constexpr bool waits_for_drive = true;`, as above; left out for hardware
/// - `struct Parameters;` with defaults, `validate()` and `set_basis(const DriveBasis<double>&)`
/// - `explicit Io(const Parameters&);`, which opens it and may throw std::runtime_error with one sentence
///
/// and, found with the parameters, the keys of its table, as `Description` has it:
///   void describe(sextant::Description& d, Io::Parameters& p);
/// Ranges of keys are always checked; `validate()` is checked after all where the power stage is chosen or
/// one of its keys is given.
template <class Io>
class OwnPowerStageOf final : public OwnPowerStage {
 public:
  typename Io::Parameters values{};

  [[nodiscard]] const char* name() const noexcept override { return Io::name; }
  [[nodiscard]] const char* meaning() const noexcept override { return Io::meaning; }
  [[nodiscard]] bool waits_for_drive() const noexcept override {
    if constexpr (requires { Io::waits_for_drive; }) {
      return Io::waits_for_drive;
    } else {
      return false;
    }
  }
  void describe_table(Section table, const DriveBasis<double>& basis) override {
    table.derive([this, &basis] { values.set_basis(basis); });
    describe_parameters(table, values);
  }
  [[nodiscard]] std::unique_ptr<DriveIo<double>> open() const override {
    return std::make_unique<Io>(values);
  }
  [[nodiscard]] std::unique_ptr<OwnPowerStage> clone() const override {
    return std::make_unique<OwnPowerStageOf>(*this);
  }
  [[nodiscard]] std::unique_ptr<OwnPowerStage> untouched() const override {
    return std::make_unique<OwnPowerStageOf>();
  }
};

/// The power stages that a program brings beside Sextant's.
using OwnPowerStages = Parts<OwnPowerStage>;

/// The power stage of class `Io`, with default parameters.
template <class Io>
[[nodiscard]] Cloned<OwnPowerStage> own_power_stage() {
  return Cloned<OwnPowerStage>{std::make_unique<OwnPowerStageOf<Io>>()};
}

/// The same list. Throws std::invalid_argument where a name is no bare TOML key, is that of another power
/// stage, or of a key or table at the top of a file of a live drive.
[[nodiscard]] OwnPowerStages checked(const OwnPowerStages& own);

}  // namespace sextant
