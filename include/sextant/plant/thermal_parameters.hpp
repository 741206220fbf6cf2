#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "sextant/core/description.hpp"

namespace sextant {

/// One value of each node of a thermal network.
template <class V>
struct ThermalNodes {
  V winding{};  ///< of the stator
  V rotor{};    ///< the cage and its iron
  V housing{};  ///< the case, with the iron of the stator

  friend constexpr bool operator==(const ThermalNodes&, const ThermalNodes&) noexcept = default;
};

/// Heat capacities and conductances of a machine, and what its resistances do with temperature
/// (`ThermalNetwork`, `PlantHeating`). None by default: temperatures are unknown and resistances constant.
template <class T = double>
struct ThermalParameters {
  ThermalNodes<T> capacity{};              ///< C; all 0: no network, and nothing else counts [J/K]
  T winding_to_rotor{};                    ///< G, thermal conductance across the air gap [W/K]
  T winding_to_housing{};                  ///< the same, through the iron of the stator [W/K]
  T rotor_to_housing{};                    ///< the same, through bearings and inner air [W/K]
  ThermalNodes<T> to_ambient{};            ///< the same of each node, to the ambient [W/K]
  T ambient{T(20)};                        ///< temperature of the ambient [°C]
  ThermalNodes<std::optional<T>> start{};  ///< temperatures at the beginning; empty: `ambient` [°C]
  T reference{T(20)};                      ///< temperature at which the machine's resistances hold [°C]
  T winding_coefficient{T(0.00393)};       ///< of R_s at `reference`; that of copper at 20 °C [1/K]
  T rotor_coefficient{T(0.00403)};         ///< of R_r at `reference`; that of aluminium at 20 °C [1/K]
  std::int32_t step_ns{10'000'000};        ///< from one move of temperatures and resistances to the next [ns]

  friend constexpr bool operator==(const ThermalParameters&, const ThermalParameters&) noexcept = default;

  [[nodiscard]] constexpr bool acts() const noexcept {
    return capacity.winding > T(0) || capacity.rotor > T(0) || capacity.housing > T(0);
  }

  /// At the beginning. [°C]
  [[nodiscard]] constexpr ThermalNodes<T> begin() const noexcept {
    return {start.winding.value_or(ambient), start.rotor.value_or(ambient), start.housing.value_or(ambient)};
  }

  /// R(ϑ)/R = 1 + α (ϑ − ϑ_ref) of the winding at a temperature [°C]. [-]
  [[nodiscard]] constexpr T winding_ratio(T temperature) const noexcept {
    return T(1) + winding_coefficient * (temperature - reference);
  }
  /// The same of the rotor.
  [[nodiscard]] constexpr T rotor_ratio(T temperature) const noexcept {
    return T(1) + rotor_coefficient * (temperature - reference);
  }

  /// C/ΣG of the node that follows its neighbours fastest. [s]
  [[nodiscard]] constexpr T shortest_time_constant() const noexcept {
    const T winding = winding_to_rotor + winding_to_housing + to_ambient.winding;
    const T rotor = winding_to_rotor + rotor_to_housing + to_ambient.rotor;
    const T housing = winding_to_housing + rotor_to_housing + to_ambient.housing;
    return std::min({capacity.winding / winding, capacity.rotor / rotor, capacity.housing / housing});
  }

  /// nullptr when usable, else what is wrong.
  [[nodiscard]] const char* validate() const noexcept {
    if (const char* problem = validate_values()) return problem;
    if (!acts()) {
      return *this == ThermalParameters{}
                 ? nullptr
                 : "conductances, temperatures and coefficients of the thermal network "
                   "need heat capacities above zero";
    }
    if (!(capacity.winding > T(0) && capacity.rotor > T(0) && capacity.housing > T(0)))
      return "winding, rotor and housing must each have a heat capacity above zero, or none of them one";
    if (!all_reach_ambient())
      return "winding, rotor and housing must each have conductances above zero on a way to the ambient, or "
             "they would heat without end";
    if (!(T(step_ns) * T(1e-9) <= largest_step * shortest_time_constant()))
      return "the step of the thermal network must be at most a tenth of its shortest time constant, a heat "
             "capacity by the sum of its conductances";
    // Losses heat: no node gets colder than the coldest of ambient and beginning.
    const ThermalNodes<T> from = begin();
    const T coldest = std::min({ambient, from.winding, from.rotor, from.housing});
    if (!(winding_ratio(coldest) > T(0) && rotor_ratio(coldest) > T(0)))
      return "the resistances must be above zero at the lowest of ambient and first temperatures";
    return nullptr;
  }

 private:
  static constexpr T largest_step = T(0.1);  ///< by the shortest time constant [-]

  /// Each value for itself.
  [[nodiscard]] const char* validate_values() const noexcept {
    for (const T x : {capacity.winding, capacity.rotor, capacity.housing, winding_to_rotor,
                      winding_to_housing, rotor_to_housing, to_ambient.winding, to_ambient.rotor,
                      to_ambient.housing, winding_coefficient, rotor_coefficient}) {
      if (!(std::isfinite(x) && x >= T(0)))
        return "heat capacities, conductances and coefficients of the thermal network must be finite and not "
               "below zero";
    }
    const ThermalNodes<T> from = begin();
    for (const T x : {ambient, reference, from.winding, from.rotor, from.housing}) {
      if (!std::isfinite(x)) return "the temperatures of the thermal network must be finite";
    }
    return step_ns > 0 ? nullptr : "the step of the thermal network must be above zero";
  }

  [[nodiscard]] constexpr bool all_reach_ambient() const noexcept {
    bool winding = to_ambient.winding > T(0);
    bool rotor = to_ambient.rotor > T(0);
    bool housing = to_ambient.housing > T(0);
    // A way has two nodes beside its own at most.
    for (int n = 0; n < 2; ++n) {
      const bool w = winding, r = rotor, h = housing;
      winding = w || (r && winding_to_rotor > T(0)) || (h && winding_to_housing > T(0));
      rotor = r || (w && winding_to_rotor > T(0)) || (h && rotor_to_housing > T(0));
      housing = h || (w && winding_to_housing > T(0)) || (r && rotor_to_housing > T(0));
    }
    return winding && rotor && housing;
  }
};

template <class T>
void describe(Description& d, ThermalParameters<T>& p) {
  auto& [capacity, winding_to_rotor, winding_to_housing, rotor_to_housing, to_ambient, ambient, start,
         reference, winding_coefficient, rotor_coefficient, step_ns] = p;
  d.number("winding_j_per_k", capacity.winding,
           {"J/K", 0, 1e9,
            "heat capacity of the stator winding, which its copper loss heats; 0, as those of rotor and "
            "housing: no thermal network, temperatures are unknown and resistances constant"});
  d.number("rotor_j_per_k", capacity.rotor,
           {"J/K", 0, 1e9, "the same of the rotor with its iron, which the loss in its resistance heats"});
  d.number("housing_j_per_k", capacity.housing,
           {"J/K", 0, 1e9,
            "the same of the housing with the stator's iron, which iron loss and viscous friction heat"});
  d.number("winding_to_rotor_w_per_k", winding_to_rotor,
           {"W/K", 0, 1e6, "thermal conductance across the air gap"});
  d.number("winding_to_housing_w_per_k", winding_to_housing,
           {"W/K", 0, 1e6, "the same from the winding through the stator's iron"});
  d.number("rotor_to_housing_w_per_k", rotor_to_housing,
           {"W/K", 0, 1e6, "the same from the rotor through bearings and inner air"});
  d.number("winding_to_ambient_w_per_k", to_ambient.winding,
           {"W/K", 0, 1e6, "the same from the winding to the ambient; each node needs a way to the ambient"});
  d.number("rotor_to_ambient_w_per_k", to_ambient.rotor,
           {"W/K", 0, 1e6, "the same from the rotor, as of a ventilated machine"});
  d.number("housing_to_ambient_w_per_k", to_ambient.housing,
           {"W/K", 0, 1e6, "the same from the housing, by surface and fan"});
  d.number("ambient_c", ambient, {"C", -100, 400, "temperature of the ambient"});
  d.number("winding_c", start.winding,
           {"C", -100, 400, "temperature of the winding at the beginning; not set: ambient_c"});
  d.number("rotor_c", start.rotor, {"C", -100, 400, "the same of the rotor"});
  d.number("housing_c", start.housing, {"C", -100, 400, "the same of the housing"});
  d.number("reference_c", reference,
           {"C", -100, 400,
            "temperature at which the resistances of [machine] hold; the drive goes on to believe in "
            "those"});
  d.number("winding_per_k", winding_coefficient,
           {"1/K", 0, 0.02, "by which R_s rises, of what it is at reference_c: 0.00393 for copper at 20 °C"});
  d.number("rotor_per_k", rotor_coefficient,
           {"1/K", 0, 0.02, "the same of R_r: 0.00403 for aluminium, 0.00393 for copper at 20 °C"});
  d.time("step_ms", step_ns,
         in_ms(1e-3, 1e3,
               "time after which temperatures and resistances move, at the beginning of a control period; "
               "they lag by half of it; at most a tenth of the shortest time constant"));
}

}  // namespace sextant
