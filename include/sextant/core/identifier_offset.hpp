#pragma once

#include <cstdint>

namespace sextant {

/// By how much the CAN identifiers of a drive, and with them its E2E data ids, lie above those of the
/// contract, so that several drives share a bus. The contract occupies one block of identifiers; a step moves
/// a drive to the next block, and the largest offset leaves every identifier a standard one (11 bits).
struct IdentifierOffset {
  static constexpr int step = 32;       ///< identifiers in a block [-]
  static constexpr int largest = 1728;  ///< [-]

  int value{0};  ///< [-]

  [[nodiscard]] constexpr const char* validate() const noexcept {
    if (value < 0 || value > largest) return "identifier_offset must be from 0 to 1728";
    if (value % step != 0) return "identifier_offset must be a multiple of 32, so that no two drives overlap";
    return nullptr;
  }

  /// The drive's identifier for one of the contract.
  [[nodiscard]] constexpr std::uint32_t id(std::uint32_t of_contract) const noexcept {
    return of_contract + static_cast<std::uint32_t>(value);
  }
  /// The drive's E2E data id for one of the contract.
  [[nodiscard]] constexpr std::uint16_t data_id(std::uint16_t of_contract) const noexcept {
    return static_cast<std::uint16_t>(of_contract + value);
  }
};

}  // namespace sextant
