#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sextant/control/electromagnetic_torque.hpp"
#include "sextant/control/estimating_controller.hpp"
#include "sextant/control/flux_comparator.hpp"
#include "sextant/control/sector_selector.hpp"
#include "sextant/control/switching_table.hpp"
#include "sextant/control/torque_comparator.hpp"
#include "sextant/control/torque_trim.hpp"
#include "sextant/control/vector_torque.hpp"
#include "sextant/core/drive_limits.hpp"

namespace sextant {

/// Conventional direct torque control (paper, 2.2): estimator → comparators → sector → switching table.
/// One switching state a period. Two additions, which `Parameters` can turn off: the flux has priority over
/// a torque that holds, and a trim of the torque reference takes the offset of the mean torque away.
///
/// The bands of torque are those at the flux reference and the nominal link voltage. The controller scales
/// them by ψ_ref u_dc, as what a vector changes of the torque in a period does (`vector_torque`): a band that
/// holds one vector would hold many at weak flux or in a sag of the link, and the torque would wander within.
template <class T = double>
class DirectTorqueController final : public EstimatingController<T> {
 public:
  static constexpr const char* name = "dtc";
  static constexpr const char* meaning = "direct torque control by a switching table";

  struct Parameters : EstimatingController<T>::Parameters {
    typename TorqueComparator<T>::Parameters torque_comparator{};
    typename FluxComparator<T>::Parameters flux_comparator{};
    typename SectorSelector<T>::Parameters sector{};
    /// In place of zero vectors the radial vector, while the flux is below its band and the current along
    /// it within the limit of magnetising [-]
    bool flux_priority{true};
    typename TorqueTrim<T>::Parameters torque_trim{};
    T u_dc{T(530)};  ///< nominal link voltage, of the bands of torque [V]

    void set_basis(const ControlBasis<T>& basis) noexcept {
      EstimatingController<T>::Parameters::set_basis(basis);
      u_dc = basis.u_dc;
    }

    /// The band of torque is that of `drive_limits`, or what the table can hold with vectors that act for a
    /// whole period, the larger one; the time constant of the trim follows from what they change.
    void set_defaults(const ControlBasis<T>& basis) noexcept {
      EstimatingController<T>::Parameters::set_defaults(basis);
      const DriveLimits<T> limits = drive_limits(basis.machine, basis.flux_reference, basis.u_dc);
      const T period = T(basis.period_ns) * T(1e-9);
      const T step = vector_torque(basis.machine, basis.flux_reference, basis.u_dc, period);
      torque_comparator.upper_band = std::max(limits.torque_band, narrowest_torque_band(step));
      torque_comparator.lower_band = torque_comparator.upper_band;
      flux_comparator.band = limits.flux_band;
      torque_trim.time_constant = default_trim_time(basis.flux_reference, basis.u_dc, period);
    }

    /// One vector for one period, from rest, changes the torque by  p ψ_ref u_dc t_period/σL_s,  which is a
    /// third of the default limit of torque, 0.4 T_b with T_b = 3/4 p ψ_ref²/σL_s, where the current moves by
    /// a fifteenth of ψ_ref/σL_s:
    ///   (2/3) u_dc t_period/σL_s > ψ_ref/(15 σL_s)
    /// Beyond it the table's ripple moves the mean torque of a millisecond off its command by more than the
    /// torque monitor allows: on the machines of the library from 200 µs on at high speed, and nowhere up to
    /// 175 µs. Both currents. [A]
    struct VectorStep {
      T current;  ///< by which one vector moves the current in a period
      T largest;  ///< that it may be
    };
    [[nodiscard]] static VectorStep vector_step(const ControlBasis<T>& basis) noexcept {
      const T leakage = basis.machine.sigma_l_s();
      const T period = T(basis.period_ns) * T(1e-9);
      return {T(2.0 / 3.0) * basis.u_dc * period / leakage, basis.flux_reference / (T(15) * leakage)};
    }

    friend void describe(Description& d, Parameters& p, const Parameters& by_default) {
      describe(d, p.torque_comparator, by_default.torque_comparator);
      describe(d, p.flux_comparator, by_default.flux_comparator);
      describe(d, p.sector);
      describe(d, p.magnetiser, by_default.magnetiser);
      d.flag("flux_priority", p.flux_priority,
             "whether below the flux band a vector along the flux takes the place of zero vectors, up to "
             "magnetising_current_a",
             Changes::always);
      describe(d, p.torque_trim, by_default.torque_trim);
    }

    [[nodiscard]] const char* validate() const noexcept {
      if (const char* problem = EstimatingController<T>::Parameters::validate()) return problem;
      if (flux_comparator.band >= this->flux_reference) {
        return "the flux band must be below the flux reference";
      }
      if (!(std::isfinite(u_dc) && u_dc > T(0))) {
        return "the nominal voltage of the DC link must be above zero";
      }
      if (const char* problem = torque_comparator.validate()) return problem;
      if (const char* problem = flux_comparator.validate()) return problem;
      if (const char* problem = sector.validate()) return problem;
      return torque_trim.validate();
    }
  };

  explicit DirectTorqueController(const Parameters& parameters) noexcept
      : Base{parameters},
        flux_priority_{parameters.flux_priority},
        priority_current_{parameters.magnetiser.current_limit},
        sigma_l_s_{parameters.machine.sigma_l_s()},
        flux_band_{parameters.flux_comparator.band},
        band_basis_{parameters.flux_reference * parameters.u_dc},
        torque_comparator_{parameters.torque_comparator},
        flux_comparator_{parameters.flux_comparator},
        sector_{parameters.sector},
        torque_trim_{parameters.torque_trim, parameters.machine, Base::period()} {}

  /// Without its trim sampling biases the mean torque against the rotation.
  [[nodiscard]] bool holds_mean_torque() const noexcept override { return torque_trim_.trims(); }

  [[nodiscard]] bool takes_parameters() const noexcept override { return true; }
  void take_parameters(const Controller<T>& from) noexcept SEXTANT_NONBLOCKING override {
    Base::take_parameters(from);
    const auto& other = static_cast<const DirectTorqueController&>(from);
    flux_priority_ = other.flux_priority_;
    flux_band_ = other.flux_band_;
    torque_comparator_.take_parameters(other.torque_comparator_);
    flux_comparator_.take_parameters(other.flux_comparator_);
    torque_trim_.take_parameters(other.torque_trim_);
  }

  /// Output of the torque comparator: +1 raise the torque, −1 lower it, 0 hold.
  [[nodiscard]] int torque_demand() const noexcept SEXTANT_NONBLOCKING { return torque_comparator_.output(); }
  /// Output of the flux comparator: true to raise the flux.
  [[nodiscard]] bool flux_demand() const noexcept SEXTANT_NONBLOCKING { return flux_comparator_.output(); }

 private:
  using Base = EstimatingController<T>;
  using Base::estimate_;
  using typename Base::Demand;

  /// The paper's Figures 2, 5 and 6: estimate, comparators and sector, switching table.
  [[nodiscard]] GatePattern follow(const Demand& d) noexcept SEXTANT_NONBLOCKING override {
    const FluxAndCurrent<T>& x = d.x;
    const T reference = torque_trim_.step(d.torque, estimate_.torque, d.psi_ref, d.u_dc, Base::rests());
    const T torque = electromagnetic_torque(Base::estimator().machine().pole_pairs, x.psi_s, x.i_s);
    const T psi_s = magnitude(x.psi_s);
    const int torque_demand =
        torque_comparator_.step((reference - torque) * (band_basis_ / (d.psi_ref * d.u_dc)));
    const T flux_error = d.psi_ref - psi_s;
    const bool raise_flux = flux_comparator_.step(flux_error);
    enter(x.psi_s);
    return Base::whole_period(
        select_state(sector_.sector(), raise_flux, torque_demand, Base::present(), needs_flux(x, flux_error)),
        d.u_dc);
  }

  void release() noexcept SEXTANT_NONBLOCKING override {
    torque_comparator_.reset();
    flux_comparator_.reset();
    torque_trim_.reset();
    enter(estimate_.psi_s);
  }

  void reset_method() noexcept SEXTANT_NONBLOCKING override { sector_.reset(); }

  /// The sector of a stator flux [Wb].
  void enter(SpaceVector<T> psi_s) noexcept {
    sector_.step(psi_s);
    estimate_.sector = estimate_.psi_s_magnitude > T(0) ? sector_.sector() : std::uint8_t{0};
  }

  /// The condition of flux priority, by the current along the rotor flux k_r ψ_r = ψ_s − σL_s i_s, which
  /// makes the field. That along the stator flux has the part of the leakage inductance beside it, which a
  /// torque near breakdown takes whatever the field is. Beyond 45° between the fluxes, or without a rotor
  /// flux, the stator flux's direction counts.
  [[nodiscard]] bool needs_flux(const FluxAndCurrent<T>& x, T flux_error) const noexcept {
    if (!flux_priority_ || flux_error <= flux_band_) return false;
    const SpaceVector<T> psi_r = x.psi_s - sigma_l_s_ * x.i_s;
    const bool holds = dot(x.psi_s, psi_r) > std::abs(cross(x.psi_s, psi_r));
    const SpaceVector<T>& axis = holds ? psi_r : x.psi_s;
    return dot(axis, x.i_s) <= priority_current_ * magnitude(axis);
  }

  bool flux_priority_;
  T priority_current_;  ///< [A]
  T sigma_l_s_;         ///< [H]
  T flux_band_;         ///< [Wb]
  T band_basis_;        ///< flux reference times link voltage, of the bands of torque [Wb·V]
  TorqueComparator<T> torque_comparator_;
  FluxComparator<T> flux_comparator_;
  SectorSelector<T> sector_;
  TorqueTrim<T> torque_trim_;
};

}  // namespace sextant
