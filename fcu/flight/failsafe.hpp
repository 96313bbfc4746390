// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "fcu/flight/flight_status.hpp"
#include "fcu/params/settings.hpp"

namespace cas::fcu {

/// Inputs of the failsafes.
struct FailsafeInput {
  double roll_rad = 0;
  double pitch_rad = 0;
  bool position_valid = false;
  bool mag_alive = true;
  bool baro_alive = true;
  bool gps_frozen = false;              ///< its last fix comes again and again
  bool gps_contradicts_itself = false;  ///< its velocity is not that of its positions
  std::uint64_t position_resets = 0;    ///< times that fixes were rejected until they were believed
  bool ground_station_seen = false;     ///< ever
  bool ground_station_alive = false;    ///< now
  bool sticks_alive = false;
  bool offboard_alive = false;
  std::optional<double> battery = 1;  ///< 0..1 of full; nullopt: unknown
};

/// The action of a failsafe.
struct FailsafeDecision {
  enum class Action { kNone, kMode, kDisarm, kTerminate };
  Action action = Action::kNone;
  FlightMode mode = FlightMode::kHold;
  std::string reason;  ///< for STATUSTEXT
  bool warning_only = false;
};

/// Watches for lost sensors, position, pilot, ground station, companion, battery and attitude while
/// armed, and returns one action per event. Actions are chosen by PX4's parameters.
class Failsafe {
 public:
  /// @param dt  s since the last call
  FailsafeDecision update(const FailsafeInput& in, const FlightParams& params, FlightMode mode,
                          bool flying, double dt);
  void reset();
  bool active() const { return active_; }

 private:
  /// Says so once, again only after the trouble has been gone.
  bool first_time(bool trouble, bool& known) {
    const bool first = trouble && !known;
    known = trouble;
    return first;
  }
  FailsafeDecision tilt(const FailsafeInput& in, const FlightParams& params, double dt);
  FailsafeDecision battery(const FailsafeInput& in, const FlightParams& params, FlightMode mode);
  FailsafeDecision position(const FailsafeInput& in, FlightMode mode, bool flying);
  FailsafeDecision links(const FailsafeInput& in, const FlightParams& params, FlightMode mode);
  FailsafeDecision sensors(const FailsafeInput& in);

  double tilted_s_ = 0;
  int battery_level_ = 0;
  bool battery_unknown_ = false;
  bool position_lost_ = false;
  bool gps_frozen_ = false;
  bool gps_contradicts_itself_ = false;
  std::optional<std::uint64_t> position_resets_;
  bool ground_station_lost_ = false;
  bool sticks_lost_ = false;
  bool offboard_lost_ = false;
  bool mag_lost_ = false;
  bool baro_lost_ = false;
  bool active_ = false;
};

}  // namespace cas::fcu
