#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "sextant/core/nonblocking.hpp"
#include "sextant/plant/appended_pair.hpp"
#include "sextant/plant/appended_system.hpp"
#include "sextant/plant/flux_pair.hpp"

namespace sextant {

/// The state of a drive plant: flux linkages, speed and angle of the machine, and the states of the appended
/// system.
template <class T, class Appended>
struct DrivePlantState {
  static constexpr int machine_size = 6;
  static constexpr int size = machine_size + Appended::size;
  static constexpr std::size_t appended_size = std::size_t(Appended::size);
  /// Elements of the state; the appended system's follow.
  enum Index : int { psi_s_alpha, psi_s_beta, psi_r_alpha, psi_r_beta, omega, theta, appended };
  using State = Eigen::Matrix<T, size, 1>;
  /// The same without the appended system's.
  using MachineState = Eigen::Matrix<T, machine_size, 1>;
  using Jacobian = Eigen::Matrix<T, size, size>;
  /// States of the appended system.
  using Integrals = std::array<T, appended_size>;

  /// x: the whole state, or that of the machine, or its slope.
  template <class Vector>
  [[nodiscard]] static FluxPair<T> fluxes(const Vector& x) noexcept SEXTANT_NONBLOCKING {
    return {{x[psi_s_alpha], x[psi_s_beta]}, {x[psi_r_alpha], x[psi_r_beta]}};
  }
  template <class Vector>
  static void put_fluxes(const FluxPair<T>& psi, Vector& x) noexcept SEXTANT_NONBLOCKING {
    x[psi_s_alpha] = psi.s.alpha;
    x[psi_s_beta] = psi.s.beta;
    x[psi_r_alpha] = psi.r.alpha;
    x[psi_r_beta] = psi.r.beta;
  }

  /// The appended system's part of a state.
  [[nodiscard]] static std::span<const T, appended_size> appended_states(const State& x) noexcept
      SEXTANT_NONBLOCKING {
    return std::span<const T, appended_size>{x.data() + machine_size, appended_size};
  }
  [[nodiscard]] static std::span<T, appended_size> appended_states(State& x) noexcept SEXTANT_NONBLOCKING {
    return std::span<T, appended_size>{x.data() + machine_size, appended_size};
  }
  /// Those of x that are the states of a part of the appended system.
  template <class Part>
    requires has_part<Part, Appended>
  [[nodiscard]] static auto states_of(const State& x) noexcept SEXTANT_NONBLOCKING {
    constexpr auto length = std::size_t(Part::size);
    return std::span<const T, length>{x.data() + machine_size + part_begin<Part, Appended>(), length};
  }
};

}  // namespace sextant
