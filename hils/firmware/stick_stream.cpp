// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/stick_stream.hpp"

#include <cmath>

namespace cas::hils {
namespace {

constexpr double kFullStick = 1000;

std::int16_t to_stick(double share) {
  return static_cast<std::int16_t>(std::lround(share * kFullStick));
}

}  // namespace

void StickStream::hold(const Sticks& sticks) {
  if (sticks_ != sticks) since_.reset();
  sticks_ = sticks;
}

std::optional<mavlink::common::ManualControl> StickStream::update(base::Duration vehicle_time) {
  if (!sticks_ || !gate_.due(vehicle_time)) return std::nullopt;
  if (!since_) since_ = vehicle_time;
  newest_ = vehicle_time;
  mavlink::common::ManualControl message;
  message.x = to_stick(sticks_->pitch);
  message.y = to_stick(sticks_->roll);
  message.z = to_stick((1 + sticks_->climb) / 2);  // the middle keeps the height
  message.r = to_stick(sticks_->yaw);
  return message;
}

}  // namespace cas::hils
