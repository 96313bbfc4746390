// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <utility>

#include "base/time/clock.hpp"
#include "casd/station/services.hpp"
#include "casd/station/vehicle_table.hpp"

namespace cas::casd {

/// The requests of a takeoff to a height above home, one after the other. Any disarm ends it: a
/// vehicle that gets the takeoff command after a disarm would take off as soon as it is armed.
class Takeoff {
 public:
  static constexpr double kHighest_m = 10'000;  ///< above home
  using Clock = std::function<base::RunTime()>;
  using SetMode = std::function<void(const KnownVehicle&, std::string_view word, Done)>;

  /// @param table  outlives this
  Takeoff(VehicleTable& table, Clock clock, SetMode set_mode)
      : table_(table), clock_(std::move(clock)), set_mode_(std::move(set_mode)) {}

  void begin(KnownVehicle& vehicle, double altitude_m, Done done);

 private:
  void to_amsl(KnownVehicle& vehicle, double altitude_m, std::uint64_t disarms, Done done);
  void in_guided(KnownVehicle& vehicle, double altitude_m, std::uint64_t disarms, Done done);
  void give(KnownVehicle& vehicle, const VehicleCommand& command, std::uint64_t disarms, Done done);

  VehicleTable& table_;
  Clock clock_;
  SetMode set_mode_;
};

}  // namespace cas::casd
