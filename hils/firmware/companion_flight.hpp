// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>

#include "base/earth/geodesy.hpp"
#include "base/time/clock.hpp"
#include "hils/firmware/companion_link.hpp"
#include "hils/firmware/vehicle_clock.hpp"
#include "hils/flight/flight_step.hpp"

namespace cas::hils {

/// Makes a stock autopilot fly tasks beyond casd's commands: trajectories, streamed as setpoints,
/// sticks and missions. PX4 flies them in OFFBOARD and MISSION, ArduCopter in GUIDED and AUTO.
/// Towards their fences PX4 flies in OFFBOARD and ArduCopter in AUTO: a command to go beyond, PX4
/// also as a mission and ArduCopter as a setpoint, is refused.
class CompanionFlight {
 public:
  /// Calls a method of casd. @throws base::rpc::CallError for a refusal
  using Call = std::function<nlohmann::json(const std::string& method, nlohmann::json params)>;
  /// Waits a moment, and notices programs that died.
  using Wait = std::function<void(base::Duration)>;

  /// Where the vehicle is.
  struct Vehicle {
    std::string autopilot{};                            ///< "PX4", "ArduPilot"
    Eigen::Vector3d hover_N = Eigen::Vector3d::Zero();  ///< where the plan has it hang, in its N, m
    Eigen::Vector3d armed_at_N = Eigen::Vector3d::Zero();  ///< where places of a step count from
    double yaw_rad = 0;
    bool not_hil = false;  ///< it may start although it does not say that it is in HIL
  };

  /// How giving a step ended.
  struct Answer {
    std::optional<std::string> refusal{};  ///< nullopt: the vehicle flies it
    bool for_good = false;                 ///< asking again would not help
    std::optional<base::SimTime> begin{};  ///< of a trajectory
    std::optional<HomedMission> mission{};
  };

  /// @param link  not connected yet; outlives the flight
  CompanionFlight(CompanionLink& link, Call call, Wait wait)
      : link_(link), call_(std::move(call)), wait_(std::move(wait)) {}

  /// Steps that it gives.
  static bool gives(StepKind kind);

  /// Joins casd's link once the vehicle is heard.
  /// @param name  of casd's link
  void join(const std::string& name);

  /// Once joined. @see CompanionStation::set_origin()
  void set_origin(const base::Geodetic& origin) {
    link_.with_station([&](auto& station) { station.set_origin(origin); });
  }

  /// Around each look at simulated time.
  void before_look();
  void after_look(base::SimTime now);

  Answer give(const FlightStep& step, const Vehicle& vehicle);
  /// The vehicle's firmware has rebooted and forgotten all requests.
  void on_reboot() { asked_for_position_ = false; }
  /// No sticks from now on, or again.
  void lose_sticks(bool lost);
  /// No setpoints any more, once the fence has the vehicle.
  void end_breach();

  /// The item of the mission under way that was reached last.
  std::optional<std::uint16_t> reached();
  SetpointFigures setpoints();

 private:
  Answer begin_sticks(const FlightStep& step, const Vehicle& vehicle);
  Answer end_sticks();
  bool centres_sticks();
  Answer begin_trajectory(const FlightStep& step, const Vehicle& vehicle);
  Answer end_trajectory(const Vehicle& vehicle);
  Answer begin_breach(const FlightStep& step, const Vehicle& vehicle);
  std::optional<std::string> enter_stream(const Vehicle& vehicle);
  Answer fly_mission(const MissionPlan& plan, const Vehicle& vehicle);
  void ask_for_position();
  bool streams();
  /// Waits until something holds for the station. @return false: it did not in good time
  template <class Holds>
  bool comes_to(Holds&& holds);
  mav::services::Outcome upload(const HomedMission& mission);

  CompanionLink& link_;
  Call call_;
  Wait wait_;
  VehicleClock clock_;
  std::optional<base::Duration> time_before_look_;
  bool asked_for_position_ = false;
  bool breaching_ = false;
};

}  // namespace cas::hils
