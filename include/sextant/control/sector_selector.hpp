#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "sextant/core/description.hpp"
#include "sextant/core/space_vector.hpp"

namespace sextant {

/// Finds the 60° sector, 1…6, in which the stator flux vector lies (paper, 2.2.3, Figures 4 and 5).
/// Sector n reaches from sector_start_deg + (n−1)·60° to sector_start_deg + n·60°, counted from V1.
/// The paper's example (40° is sector 1, 130° is sector 3) has two readings: sectors centred on the
/// vectors, −30, in a frame where V1 lies at 30°; or sectors that start on V1, 0.
/// The sector is kept between steps; at ψ = 0, which lies in every sector, it stays.
template <class T = double>
class SectorSelector {
 public:
  struct Parameters {
    T sector_start_deg{T(-30)};  ///< lower edge of sector 1, from V1 [°]

    friend void describe(Description& d, Parameters& p) {
      auto& [start_deg] = p;
      d.number("sector_start_deg", start_deg,
               {"deg", -180, 180,
                "lower edge of sector 1 of the switching table, from voltage vector 1; -30: symmetrical to "
                "the vectors"});
    }

    [[nodiscard]] const char* validate() const noexcept {
      const bool good = std::isfinite(sector_start_deg) && std::abs(sector_start_deg) <= T(180);
      return good ? nullptr : "the start of sector 1 must lie from -180 to 180 degrees";
    }
  };

  explicit SectorSelector(const Parameters& parameters) noexcept {
    for (int n = 0; n < 6; ++n) {
      const T degrees = parameters.sector_start_deg + T(60 * n);
      edges_[unsigned(n)] = polar(T(1), degrees * std::numbers::pi_v<T> / T(180));
    }
    edges_[6] = edges_[0];
  }

  /// Updates the sector by the stator flux [Wb]; returns it.
  constexpr std::uint8_t step(SpaceVector<T> psi_s) noexcept {
    constexpr int most_crossings = 3;  // to the opposite sector
    for (int n = 0; n < most_crossings; ++n) {
      const std::array<T, 2> distance = thresholds(psi_s);
      if (distance[0] < T(0)) {
        on_crossing(0);
      } else if (distance[1] < T(0)) {
        on_crossing(1);
      } else {
        break;
      }
    }
    return sector();
  }

  [[nodiscard]] constexpr std::uint8_t sector() const noexcept { return std::uint8_t(index_ + 1U); }

  /// Distances [Wb] of ψ_s from the lower and the upper edge of the present sector, positive inside:
  ///   ê_lower × ψ_s  and  ψ_s × ê_upper.
  [[nodiscard]] constexpr std::array<T, 2> thresholds(SpaceVector<T> psi_s) const noexcept {
    return {cross(edges_[index_], psi_s), cross(psi_s, edges_[index_ + 1U])};
  }

  /// Crossing the lower edge (0) leads to the sector before, the upper edge (1) to the one after.
  constexpr void on_crossing(int edge) noexcept {
    if (edge == 0) {
      index_ = index_ == 0U ? 5U : index_ - 1U;
    } else {
      index_ = index_ == 5U ? 0U : index_ + 1U;
    }
  }

  constexpr void reset() noexcept { index_ = 0U; }

 private:
  std::array<SpaceVector<T>, 7> edges_{};  ///< lower edge of each sector; the first once more at the end
  std::size_t index_{0};                   ///< the sector − 1
};

}  // namespace sextant
