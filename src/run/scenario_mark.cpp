#include "sextant/run/scenario_mark.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sextant {
namespace {

class Hash {
 public:
  template <class T>
  void add(const T& value) noexcept {
    for (const std::uint8_t byte : std::bit_cast<std::array<std::uint8_t, sizeof(T)>>(value))
      value_ = (value_ ^ byte) * 16'777'619U;
  }
  void add(const std::vector<ProfilePoint>& points) noexcept {
    add(points.size());
    for (const ProfilePoint& point : points) {
      add(point.t_s);
      add(point.value);
    }
  }
  [[nodiscard]] std::uint32_t value() const noexcept { return value_; }

 private:
  std::uint32_t value_{2'166'136'261U};
};

}  // namespace

std::uint32_t scenario_mark(const Scenario& scenario) noexcept {
  const ProfileParameters& torque = scenario.torque_reference;
  Hash hash;
  hash.add(scenario.duration_ns);
  hash.add(torque.shape);
  for (const double number : {torque.value, torque.amplitude, torque.frequency_hz, torque.phase_deg})
    hash.add(number);
  hash.add(torque.points);
  hash.add(torque.table);
  return hash.value() == 0 ? 1 : hash.value();
}

}  // namespace sextant
