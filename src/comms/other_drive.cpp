#include "sextant/comms/other_drive.hpp"

#include <algorithm>

#include "sextant/comms/can_codec.hpp"

namespace sextant {

OtherDrive::OtherDrive(IdentifierOffset offset) noexcept
    : offset_{offset}, checker_{torque_status_data_id(offset)} {}

bool OtherDrive::sent(const CanFrame& frame) noexcept {
  if (!decode_torque_status(frame, offset_)) return false;
  e2e::Data data{};
  std::copy_n(frame.data.begin(), data.size(), data.begin());
  return usable(checker_.check(data)) && checker_.state() == E2eState::valid;
}

}  // namespace sextant
