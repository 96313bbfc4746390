// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/station/gain_map.hpp"
#include "casd/station/vehicle_commander.hpp"
#include "hils/flight/flight_plan.hpp"
#include "hils/flight/flight_step.hpp"
#include "hils/programs/pilot_calls.hpp"

namespace cas::hils {

/// casd's command port without sockets: its methods about vehicles, called in this process.
class VirtualPort {
 public:
  /// @param commander  outlives the port
  VirtualPort(casd::VehicleCommander& commander, casd::GainMap gains,
              std::function<base::RunTime()> now);
  ~VirtualPort();

  /// State of a vehicle as casd knows it, without what only reports of stock firmware need.
  VehicleReport report(std::uint8_t system) const;

  using Done = std::function<void(const std::optional<Refusal>& refusal)>;
  /// Has a vehicle do a step. @param done  called once; nullopt: all calls were accepted
  void give(const FlightStep& step, std::uint8_t system, const Done& done);

 private:
  struct Methods;
  void call(const std::vector<CasdCall>& calls, std::size_t first, const Done& done);

  casd::VehicleCommander& commander_;
  std::unique_ptr<Methods> methods_;
};

}  // namespace cas::hils
