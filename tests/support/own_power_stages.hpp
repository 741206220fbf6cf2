#pragma once

#include <stdexcept>

#include "sextant/config/own_power_stage.hpp"
#include "sextant/core/supervised_drive_io.hpp"

/// Power stages as somebody writes them outside of Sextant.
namespace elsewhere {

/// Hardware with a line that turns its gates off.
class Inverter final : public sextant::SupervisedDriveIo<double> {
 public:
  static constexpr const char* name = "inverter";
  static constexpr const char* meaning = "hardware of this test";

  struct Parameters {
    std::int32_t period_ns{};
    double scale{2};

    void set_basis(const sextant::DriveBasis<double>& basis) noexcept { period_ns = basis.period_ns; }
    [[nodiscard]] const char* validate() const noexcept {
      return period_ns > 100'000 && scale > 1 ? "the scale is too high for the period" : nullptr;
    }
  };

  explicit Inverter(const Parameters& p) : p_{p} {
    if (p.scale == 5) throw std::runtime_error{"inverter.scale: /dev/inverter5 is not there"};
  }

  [[nodiscard]] sextant::Measurement<double> read(std::int64_t) noexcept SEXTANT_NONBLOCKING override {
    sextant::Measurement<double> m;
    m.u_dc = p_.scale;
    return m;
  }
  void write(const sextant::GatePattern&) noexcept SEXTANT_NONBLOCKING override {}
  void inhibit_gates() noexcept override { ++inhibitions; }
  void announce_end() noexcept override { has_ended = true; }
  [[nodiscard]] const char* loss() const noexcept override { return is_lost ? "has lost its FPGA" : nullptr; }

  int inhibitions{0};
  bool has_ended{false};
  bool is_lost{false};

 private:
  Parameters p_;
};

inline void describe(sextant::Description& d, Inverter::Parameters& p) {
  d.number("scale", p.scale, {"V", 0, 10, "of the link voltage"});
}

/// A model, which waits for the drive.
class Model final : public sextant::DriveIo<double> {
 public:
  static constexpr const char* name = "model";
  static constexpr const char* meaning = "a model of this test";
  static constexpr bool waits_for_drive = true;

  struct Parameters {
    void set_basis(const sextant::DriveBasis<double>&) noexcept {}
    [[nodiscard]] const char* validate() const noexcept { return nullptr; }
  };

  explicit Model(const Parameters&) {}
  [[nodiscard]] sextant::Measurement<double> read(std::int64_t) noexcept SEXTANT_NONBLOCKING override {
    return {};
  }
  void write(const sextant::GatePattern&) noexcept SEXTANT_NONBLOCKING override {}
};

inline void describe(sextant::Description&, Model::Parameters&) {}

}  // namespace elsewhere
