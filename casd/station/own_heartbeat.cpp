// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/own_heartbeat.hpp"

#include <vector>

#include "mavlink/common/enums.hpp"
#include "mavlink_gen/services/station_heartbeat.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;

Heartbeat of_a_station() { return mav::services::station_heartbeat(MavType::kGcs); }

void note(KnownVehicle& vehicle, base::RunTime now) {
  vehicle.beat_at = vehicle.state.boot_time().value_or(base::Duration{});
  vehicle.beat_sent = now;
}

}  // namespace

void OwnHeartbeat::set_rate(double rate_hz) {
  if (rate_hz != rate_hz_) next_.reset();  // at the old rate the next one may be far away
  rate_hz_ = rate_hz;
}

void OwnHeartbeat::tick(const VehicleTable::Vehicles& vehicles, base::RunTime now) {
  if (rate_hz_ <= 0) return;
  if (!next_) next_ = now;
  if (now < *next_) return;
  const base::Duration period = base::from_seconds(1.0 / rate_hz_);
  *next_ += period;
  if (now >= *next_) next_ = now + period;
  for (const auto& [system, vehicle] : vehicles) note(*vehicle, now);
  send_(of_a_station(), {});
}

void OwnHeartbeat::keep_up(KnownVehicle& vehicle, base::RunTime now) {
  constexpr double kPeriods = 2;
  constexpr base::Duration kLeast = std::chrono::milliseconds(10);  // whatever its clock says
  const std::optional<base::Duration> clock = vehicle.state.boot_time();
  if (!clock || rate_hz_ <= 0) return;
  if (*clock < vehicle.beat_at) vehicle.beat_at = *clock;
  if (*clock - vehicle.beat_at < base::from_seconds(kPeriods / rate_hz_)) return;
  const std::vector<Path> paths = vehicle.state.paths();
  if (paths.empty() || now - vehicle.beat_sent < kLeast) return;
  note(vehicle, now);
  send_(of_a_station(), paths);
}

}  // namespace cas::casd
