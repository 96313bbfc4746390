// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/config/config.hpp"
#include "base/time/clock.hpp"
#include "casd/station/gain_map.hpp"
#include "fcu/flight/trajectory.hpp"
#include "hils/flight/flight_facts.hpp"
#include "hils/flight/geofence.hpp"
#include "hils/flight/mission_plan.hpp"

namespace cas::hils {

/// Name of the vehicle of a run that has but one, and the folder of its topics.
inline constexpr std::string_view kVehicleName = "iris0";

/// The vehicles of a scenario by name, in its order.
using VehicleNames = std::vector<std::string>;
/// The names in a scenario with one vehicle.
inline VehicleNames only_vehicle() { return {std::string(kVehicleName)}; }

/// Reads the optional key `vehicle` of a step or a fault.
///
/// @return its place among `names`; nullopt when the key is not there
/// @throws base::ConfigError for a name that is not among them, with those that are
std::optional<std::size_t> parse_vehicle_key(const base::ConfigNode& node,
                                             const VehicleNames& names);

/// Kinds of steps of a flight.
enum class StepKind {
  kArm,         ///< done when the vehicle says that it is armed
  kTakeoff,     ///< done when it hangs still at the height, on its wing when it has climbed to it
  kGoto,        ///< done when it hangs still at the place
  kHold,        ///< done when `duration` of simulated time has passed
  kTrajectory,  ///< done when it has been flown for `duration`
  kSticks,      ///< done when the sticks have been held for `duration`
  kSetGain,     ///< done when the vehicle has confirmed the gains
  kSetParam,    ///< done when the vehicle has confirmed the parameters
  kWaitUntil,   ///< done when the condition holds
  kMission,     ///< done when the vehicle has reached the last item, and landed if that says so
  kLoiter,      ///< done when it has flown on its circle for a while
  kTransition,  ///< done when a VTOL says that it flies as asked for
  kBreach,      ///< done when the autopilot's own fence has taken the vehicle over
  kRtl,         ///< done when it is on the ground at home, or hangs still above it
  kLand,        ///< done when the vehicle reports that it is on the ground
  kDisarm,      ///< done when it says that it is disarmed
  kReboot,      ///< done when its firmware has started again, and knows its parameters
  // From here on: no word of a scenario.
  /// Done when the vehicle has confirmed; follows each trajectory, and sticks, by itself.
  kEndTrajectory,
  kStandBy,  ///< another vehicle's step: done when the others have done it
};

std::string_view to_string(StepKind kind);

/// A path about the place where the vehicle hangs, flown by the controller itself.
struct Trajectory {
  fcu::PatternShape shape = fcu::PatternShape::kNone;
  double size_m = 0;
  double speed_m_s = 1;
  double period_s = 10;

  fcu::Pattern pattern() const { return {shape, size_m, speed_m_s, period_s}; }
};

/// Sticks of a remote control, -1 to 1 each; at 0 an autopilot keeps place, heading and height.
struct Sticks {
  double pitch = 0;  ///< forward
  double roll = 0;   ///< to the right
  double yaw = 0;    ///< clockwise
  double climb = 0;  ///< up

  bool operator==(const Sticks&) const = default;
};

/// One step of a flight. Positions are in N with height up, relative to where the vehicle was
/// armed.
struct FlightStep {
  StepKind kind = StepKind::kHold;
  std::string
      name{};  ///< for reports, and `phase` in conditions; the step's word where none is given
  std::optional<std::size_t> vehicle{};  ///< index of the vehicle that flies it; nullopt: all do
  base::Duration timeout = std::chrono::seconds(30);  ///< simulated time until the step has failed
  double altitude_m = 0;                              ///< takeoff
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();  ///< goto, loiter, breach: north, east, up
  double radius_m = 0;                  ///< loiter: of its circle; below 0 counter-clockwise
  bool to_plane = false;                ///< transition: onto the wing, else onto the rotors
  double yaw_rad = 0;                   ///< goto
  base::Duration duration{};            ///< hold, trajectory, sticks
  bool measure = false;                 ///< hold, trajectory: the window of all figures
  Trajectory trajectory{};              ///< trajectory; of a breach the speed
  std::optional<Sticks> sticks{};       ///< sticks, and their end
  std::string loop{};                   ///< setgain
  std::optional<double> p{}, i{}, d{};  ///< setgain
  std::vector<std::pair<std::string, double>> params{};  ///< setparam, trajectory and its end
  std::optional<Condition> until{};                      ///< wait_until
  MissionPlan mission{};                                 ///< mission
  std::optional<FenceAction> fence{};                    ///< breach: action of the fence
  double reach_m = 0;  ///< breach, and mission once home is known: farthest place from home
  std::vector<MissionPlace> places{};  ///< mission: of its waypoints, once home is known
  bool ends_holding = false;           ///< rtl: the vehicle is set to stay above home
};

/// The step's name, or the word of its kind.
std::string_view phase_of(const FlightStep& step);
/// Whether the vehicle is in the air after the step that was on the ground before it.
bool takes_off(const FlightStep& step);
/// Farthest place at which a plane may stand that has landed: it touches down beyond its point, and
/// runs out.
inline constexpr double kRunOut_m = 150;
/// A vehicle flies on its circle within this share of the radius: ArduPlane flies wide of a tight
/// one.
inline constexpr double kOnCircleShare = 0.1;

/// Whether the vehicle may be on the ground, disarmed, at the end of the step.
bool lands(const FlightStep& step);
/// Whether the step sends the vehicle a command.
bool is_command(StepKind kind);

/// Reads the list `steps`: each entry is a word (`arm`) or a map with one key (`takeoff:
/// {altitude_m: 2.5}`). Checks that the flight is possible: armed before takeoff, exactly one
/// measured step, landed at the end, and that loops and gains of setgain are known.
///
/// With several vehicles each must be able to fly its steps, and all of them are in the air
/// in the measured step.
///
/// @param gains  loops of casd's gain map; when it is empty, any loop is taken
/// @param names  vehicles that a step may name
/// @throws base::ConfigError
std::vector<FlightStep> parse_flight(const base::ConfigNode& steps, const casd::GainMap& gains,
                                     const VehicleNames& names = only_vehicle());

/// The sticks that a step holds from its begin, or centred at their end; nullopt: it has none.
std::optional<Sticks> held_sticks(const FlightStep& step);

/// Missions, breaches and reboots are for stock firmware, circles and transitions also for vehicles
/// with a wing. @throws base::ConfigError at the first that is not flown
void refuse_firmware_steps(const base::ConfigNode& steps, bool has_wing);

/// The steps of one vehicle: those of others are replaced by kStandBy.
std::vector<FlightStep> steps_for(std::size_t vehicle, const std::vector<FlightStep>& flight);

}  // namespace cas::hils
