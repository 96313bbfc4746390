// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/stream_time.hpp"

#include "mavlink/common/hil_sensor.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::casd {

using mavlink::common::HilSensor;

base::RunTime StreamTime::now() const {
  const base::MutexLock lock(mutex_);
  return clock_.now();
}

bool StreamTime::is_sensor(const mav::PacketView& packet) {
  return packet.message_id == HilSensor::kId;
}

std::optional<base::RunTime> StreamTime::advance(const mav::PacketView& packet) {
  const std::optional<HilSensor> sensor = mav::decode<HilSensor>(packet);
  if (!sensor) return std::nullopt;
  const base::MutexLock lock(mutex_);
  clock_.on_sensor(sensor->time_usec);
  const base::RunTime now = clock_.now();
  if (next_turn_ && now < *next_turn_) return std::nullopt;
  // On a grid, so that turns do not depend on when a stream began.
  next_turn_ = base::RunTime((now.time_since_epoch() / kTurnPeriod + 1) * kTurnPeriod);
  return now;
}

}  // namespace cas::casd
