#include "cycle_row.hpp"

#include <cstddef>
#include <type_traits>
#include <utility>

namespace sextant {
namespace {

// A member that is added to a record and not named in both directions below does not compile; a member of
// CycleRow that is not in its type makes the test of the round trip red.

PatternRow to_row(const GatePattern& pattern) noexcept {
  PatternRow row;
  for (const GateSegment& segment : pattern.segments()) {
    row.state[row.segments] = std::uint8_t(segment.state.code());
    row.duration_ns[row.segments] = segment.duration_ns;
    ++row.segments;
  }
  return row;
}

LegState leg(std::uint8_t code, unsigned n) noexcept {
  const unsigned bits = unsigned{code} >> n;
  if ((bits & 8U) == 0U) return LegState::off;
  return (bits & 1U) != 0U ? LegState::high : LegState::low;
}

GatePattern to_pattern(const PatternRow& row) noexcept {
  GatePattern pattern;
  for (std::size_t k = 0; k < row.segments && k < GatePattern::capacity; ++k) {
    const std::uint8_t code = row.state[k];
    (void)pattern.append({{leg(code, 0), leg(code, 1), leg(code, 2)}, row.duration_ns[k]});
  }
  return pattern;
}

FaultSet to_faults(std::uint64_t bits) noexcept {
  FaultSet faults;
  for (unsigned n = 0; n < 64; ++n) {
    if ((bits >> n & 1U) != 0U) faults.set(Fault{std::uint8_t(n)});
  }
  return faults;
}

TorqueCommand<double> to_command(const CycleRow& row) noexcept {
  TorqueCommand<double> command;
  auto& [torque, torque_limit, enable, fault_reset, received_ns, sequence, disables, resets, rejected,
         counter, e2e, out_of_range, bus_off, second_sender] = command;
  torque = row.torque_nm;
  torque_limit = row.torque_limit_nm;
  enable = row.enable != 0;
  fault_reset = row.fault_reset != 0;
  received_ns = row.received_ns;
  sequence = row.command_sequence;
  disables = row.disables;
  resets = row.resets;
  rejected = row.rejected;
  counter = row.counter;
  e2e = E2eState{row.e2e};
  out_of_range = row.out_of_range;
  bus_off = row.bus_off != 0;
  second_sender = row.second_sender != 0;
  return command;
}

Measurement<double> to_measurement(const CycleRow& row) noexcept {
  Measurement<double> measurement;
  auto& [i_abc, u_dc, omega_m, applied, plausible, theta_m, winding_temperature] = measurement;
  i_abc = {row.i_a_a, row.i_b_a, row.i_c_a};
  u_dc = row.u_dc_v;
  omega_m = row.speed_rad_s;
  applied = to_pattern(row.applied);
  plausible = row.plausible != 0;
  if (row.has_theta_m != 0) theta_m = row.theta_m_rad;
  if (row.has_winding_temperature != 0) winding_temperature = row.winding_temperature_c;
  return measurement;
}

DriveRequest<double> to_request(const CycleRow& row) noexcept {
  DriveRequest<double> request;
  auto& [command, shutdown, status_age_ns, external] = request;
  command = to_command(row);
  shutdown = row.shutdown != 0;
  status_age_ns = row.status_age_ns;
  external = to_faults(row.external);
  return request;
}

/// Members of a compound type.
template <class Struct>
class CompoundType {
 public:
  CompoundType() : type_{H5Tcreate(H5T_COMPOUND, sizeof(Struct)), H5Tclose} {}

  void add(const char* name, std::size_t offset, hid_t kind) {
    hdf5::check(H5Tinsert(type_.get(), name, offset, kind));
  }
  [[nodiscard]] hdf5::Handle take() { return std::move(type_); }

 private:
  hdf5::Handle type_;
};

template <class T>
hid_t native() {
  if constexpr (std::is_same_v<T, double>) return H5T_NATIVE_DOUBLE;
  if constexpr (std::is_same_v<T, std::int64_t>) return H5T_NATIVE_INT64;
  if constexpr (std::is_same_v<T, std::uint64_t>) return H5T_NATIVE_UINT64;
  if constexpr (std::is_same_v<T, std::int32_t>) return H5T_NATIVE_INT32;
  if constexpr (std::is_same_v<T, std::uint32_t>) return H5T_NATIVE_UINT32;
  if constexpr (std::is_same_v<T, std::uint8_t>) return H5T_NATIVE_UINT8;
}

hdf5::Handle array_type(hid_t element) {
  const hsize_t size = GatePattern::capacity;
  return {H5Tarray_create2(element, 1, &size), H5Tclose};
}

hdf5::Handle pattern_row_type() {
  CompoundType<PatternRow> type;
  type.add("segments", offsetof(PatternRow, segments), H5T_NATIVE_UINT8);
  type.add("state", offsetof(PatternRow, state), array_type(H5T_NATIVE_UINT8).get());
  type.add("duration_ns", offsetof(PatternRow, duration_ns), array_type(H5T_NATIVE_INT32).get());
  return type.take();
}

}  // namespace

CycleRow to_row(const CycleRecord<double>& record) noexcept {
  const auto& [t_ns, measurement, request, pattern] = record;
  const auto& [i_abc, u_dc, omega_m, applied, plausible, theta_m, winding_temperature] = measurement;
  const auto& [command, shutdown, status_age_ns, external] = request;
  const auto& [torque, torque_limit, enable, fault_reset, received_ns, sequence, disables, resets, rejected,
               counter, e2e, out_of_range, bus_off, second_sender] = command;
  return {.t_ns = t_ns,
          .i_a_a = i_abc.a,
          .i_b_a = i_abc.b,
          .i_c_a = i_abc.c,
          .u_dc_v = u_dc,
          .speed_rad_s = omega_m,
          .theta_m_rad = theta_m.value_or(0.0),
          .has_theta_m = std::uint8_t(theta_m.has_value()),
          .winding_temperature_c = winding_temperature.value_or(0.0),
          .has_winding_temperature = std::uint8_t(winding_temperature.has_value()),
          .plausible = std::uint8_t(plausible),
          .applied = to_row(applied),
          .torque_nm = torque,
          .torque_limit_nm = torque_limit,
          .enable = std::uint8_t(enable),
          .fault_reset = std::uint8_t(fault_reset),
          .received_ns = received_ns,
          .command_sequence = sequence,
          .disables = disables,
          .resets = resets,
          .rejected = rejected,
          .counter = counter,
          .e2e = std::uint8_t(e2e),
          .out_of_range = out_of_range,
          .bus_off = std::uint8_t(bus_off),
          .second_sender = std::uint8_t(second_sender),
          .shutdown = std::uint8_t(shutdown),
          .status_age_ns = status_age_ns,
          .external = external.bits(),
          .pattern = to_row(pattern)};
}

CycleRecord<double> to_record(const CycleRow& row) noexcept {
  return {.t_ns = row.t_ns,
          .measurement = to_measurement(row),
          .request = to_request(row),
          .pattern = to_pattern(row.pattern)};
}

hdf5::Handle cycle_row_type() {
  const hdf5::Handle pattern = pattern_row_type();
  CompoundType<CycleRow> type;
#define SEXTANT_ADD(member) \
  type.add(#member, offsetof(CycleRow, member), native<decltype(CycleRow::member)>())
  SEXTANT_ADD(t_ns);
  SEXTANT_ADD(i_a_a);
  SEXTANT_ADD(i_b_a);
  SEXTANT_ADD(i_c_a);
  SEXTANT_ADD(u_dc_v);
  SEXTANT_ADD(speed_rad_s);
  SEXTANT_ADD(theta_m_rad);
  SEXTANT_ADD(has_theta_m);
  SEXTANT_ADD(winding_temperature_c);
  SEXTANT_ADD(has_winding_temperature);
  SEXTANT_ADD(plausible);
  type.add("applied", offsetof(CycleRow, applied), pattern.get());
  SEXTANT_ADD(torque_nm);
  SEXTANT_ADD(torque_limit_nm);
  SEXTANT_ADD(enable);
  SEXTANT_ADD(fault_reset);
  SEXTANT_ADD(received_ns);
  SEXTANT_ADD(command_sequence);
  SEXTANT_ADD(disables);
  SEXTANT_ADD(resets);
  SEXTANT_ADD(rejected);
  SEXTANT_ADD(counter);
  SEXTANT_ADD(e2e);
  SEXTANT_ADD(out_of_range);
  SEXTANT_ADD(bus_off);
  SEXTANT_ADD(second_sender);
  SEXTANT_ADD(shutdown);
  SEXTANT_ADD(status_age_ns);
  SEXTANT_ADD(external);
  type.add("pattern", offsetof(CycleRow, pattern), pattern.get());
#undef SEXTANT_ADD
  return type.take();
}

}  // namespace sextant
