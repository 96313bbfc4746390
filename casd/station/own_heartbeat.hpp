// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "base/time/clock.hpp"
#include "casd/station/vehicle_table.hpp"
#include "mavlink/common/heartbeat.hpp"

namespace cas::casd {

/// Sends casd's own HEARTBEAT as a ground station; without it PX4 reports a lost ground station.
/// Pure.
class OwnHeartbeat {
 public:
  /// To these paths alone, or, without paths, to every link.
  using Send = std::function<void(const mavlink::common::Heartbeat&, std::span<const Path> to)>;

  /// @param rate_hz  0: silent
  OwnHeartbeat(double rate_hz, Send send) : rate_hz_(rate_hz), send_(std::move(send)) {}

  void set_rate(double rate_hz);
  /// Sends to every link, at the rate.
  void tick(const VehicleTable::Vehicles& vehicles, base::RunTime now);
  /// When tick() has something to send; nothing: never.
  std::optional<base::RunTime> due() const {
    if (rate_hz_ <= 0) return std::nullopt;
    return next_.value_or(base::RunTime{});
  }
  /// Sends to a vehicle that runs faster than real time, by its own clock: at 20 times real time
  /// PX4 v1.16 missed its ground station between two ticks and returned home.
  void keep_up(KnownVehicle& vehicle, base::RunTime now);

 private:
  double rate_hz_;
  Send send_;
  std::optional<base::RunTime> next_;
};

}  // namespace cas::casd
