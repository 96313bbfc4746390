// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/stick_stream.hpp"

#include "hils/programs/ground_station.hpp"

namespace cas::hils {

void StickStream::hold(const Sticks& sticks) {
  if (sticks_ != sticks) since_.reset();
  sticks_ = sticks;
}

std::optional<mavlink::common::ManualControl> StickStream::update(base::Duration vehicle_time) {
  if (!sticks_ || !gate_.due(vehicle_time)) return std::nullopt;
  if (!since_) since_ = vehicle_time;
  newest_ = vehicle_time;
  if (lost_) return std::nullopt;
  return manual_control(*sticks_);
}

}  // namespace cas::hils
