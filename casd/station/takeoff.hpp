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
  /// @param not_hil  consents to a vehicle that is not in HIL
  using SetMode =
      std::function<void(const KnownVehicle&, std::string_view word, bool not_hil, Done)>;
  using Start = std::function<void(const KnownVehicle&, const VehicleCommand&, bool not_hil, Done)>;

  /// @param table  outlives this
  Takeoff(VehicleTable& table, Clock clock, SetMode set_mode, Start start)
      : table_(table),
        clock_(std::move(clock)),
        set_mode_(std::move(set_mode)),
        start_(std::move(start)) {}

  void begin(KnownVehicle& vehicle, double altitude_m, bool not_hil, Done done);

 private:
  struct Request {
    double altitude_m;
    bool not_hil;
    std::uint64_t disarms;  ///< how many there were before it
    Done done;
  };
  void to_amsl(KnownVehicle& vehicle, const Request& request);
  void in_guided(KnownVehicle& vehicle, const Request& request);
  void in_takeoff_mode(KnownVehicle& vehicle, const Request& request);
  void with_height(KnownVehicle& vehicle, const Request& request,
                   std::function<void(const Request&)> take_off);
  bool overtaken(const KnownVehicle& vehicle, const Request& request);
  void give(KnownVehicle& vehicle, const VehicleCommand& command, const Request& request);

  VehicleTable& table_;
  Clock clock_;
  SetMode set_mode_;
  Start start_;
};

}  // namespace cas::casd
