// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/time/clock.hpp"
#include "hils/flight/flight_step.hpp"

namespace cas::hils {

/// Why a vehicle did not take a command.
struct Refusal {
  std::string why;
};

/// State of the vehicle as casd knows it.
struct VehicleReport {
  bool heard = false;          ///< its HEARTBEAT has come
  double heartbeat_age_s = 0;  ///< of the newest, by casd's clock
  std::string firmware{};      ///< its version; empty until it is known
  std::string autopilot{};     ///< "PX4", "ArduPilot", "other"
  std::string type{};          ///< casd's word for its MAV_TYPE: "quadrotor"
  std::string vtol{};          ///< of a VTOL: "multicopter", "to_plane", "plane", "to_multicopter"
  bool hil = false;            ///< its HEARTBEAT says that it is in HIL
  bool armed = false;
  bool in_air = false;
  bool on_ground = false;
  bool has_position = false;
  double position_age_s = 0;                   ///< of p_N and v_N, by casd's clock
  std::optional<std::string> position_lack{};  ///< missing for a takeoff by position
  /// m, from the vehicle's own origin; after FlightPlan::from_arming() from where it was armed
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();  ///< m/s
  double roll_rad = 0;
  double pitch_rad = 0;
  double yaw_rad = 0;
  std::optional<Motion> truth{};  ///< the simulator's, where it is at hand
  std::string fence_words{};      ///< its newest text about a breach of its fence
  double fence_words_age_s = 0;   ///< by casd's clock
  std::string mode{};             ///< by its HEARTBEAT; empty: not asked for
  std::string warning{};          ///< its newest recent text of severity warning or worse
  std::optional<std::uint16_t> mission_reached{};  ///< of the mission under way, by the wire

  /// Whether it flies on its wing, and can hang nowhere.
  bool on_wing() const { return vtol.empty() ? type == "fixed_wing" : vtol == "plane"; }
  /// Motion by the vehicle's own estimate.
  Motion estimate() const;
};

/// One step of the flight as it went.
struct Stage {
  FlightStep step;
  base::SimTime begin;
  base::SimTime end;
  base::SimTime accepted;  ///< when the vehicle confirmed the command; else the begin
  Eigen::Vector3d reference_m = Eigen::Vector3d::Zero();  ///< north, east, up from the start
  double reference_yaw_rad = 0;
  double circle_m = 0;   ///< radius of the circle about the reference that it is to fly; 0: none
  bool on_wing = false;  ///< at the end, by its own word
  Eigen::Vector3d armed_at_N = Eigen::Vector3d::Zero();  ///< place of arming in the vehicle's frame
};

/// Differences of stock firmware from our controller.
struct FirmwareHabits {
  /// The vehicle accepts arming before it can take off, and disarms itself on the ground (PX4
  /// v1.12.0 after 8 s, ArduCopter 4.5.6 after 10 s). So it is armed once it has its position, and
  /// a flight in which it is disarmed before it has lifted off has failed: it is not armed again.
  bool arms_early = false;
  /// A landed vehicle disarms itself within this long; a disarm step leaves it the time.
  base::Duration disarms_itself{};
  /// Trajectories are streamed to the vehicle as setpoints (PX4: OFFBOARD, ArduCopter: GUIDED).
  bool flies_setpoints = false;
};

/// Takes a vehicle through the steps of a scenario. It decides the next command and when a step is
/// done; it sends none itself and reads no clock. FleetPlan keeps several in step.
///
///   update() -> command -> on_outcome() -> update() until the step's condition holds -> next step
class FlightPlan {
 public:
  static constexpr base::Duration kLookPeriod = std::chrono::milliseconds(50);
  /// A vehicle that is disarmed in the air is noticed within this long.
  static constexpr base::Duration kLongestLook = std::chrono::milliseconds(500);
  /// `others_through` of a vehicle that flies alone.
  static constexpr std::size_t kNobody = std::numeric_limits<std::size_t>::max();

  /// @param start_yaw_rad  heading of the vehicle at the start, kept until a step sets another
  explicit FlightPlan(std::vector<FlightStep> steps, double start_yaw_rad = 0,
                      FirmwareHabits habits = {});

  /// The report with its position from the place of arming, for each look before update(). A
  /// vehicle's origin lies off that place by as much as its estimate has moved since it was set.
  /// The place is the last one while a step arms the vehicle.
  VehicleReport from_arming(VehicleReport vehicle);
  /// The place of arming in the vehicle's own frame.
  const Eigen::Vector3d& armed_at_N() const { return armed_at_N_; }

  /// Looks at the vehicle. @return the step whose command is due now, if any; the place of a goto
  /// counts from the vehicle's own origin, as commands do
  /// @param others_through  number of steps that the other vehicles have finished: the next one
  ///     begins
  std::optional<FlightStep> update(base::SimTime now, const VehicleReport& vehicle,
                                   std::size_t others_through = kNobody);
  /// The vehicle's answer to the last command; no refusal: it was accepted. A refused command is
  /// given again each second until the step's time is over.
  void on_outcome(base::SimTime now, const std::optional<Refusal>& refusal = {});

  bool done() const { return current_ == steps_.size(); }
  /// Steps that the vehicle has done, and whether it has begun with the next one.
  std::size_t completed() const { return current_; }
  /// Steps that it has in all.
  std::size_t size() const { return steps_.size(); }
  bool begun() const { return begun_; }
  /// Steps that other vehicles need not wait for: those done, and a standby step under way.
  std::size_t through() const { return current_ + (stands_by() ? 1 : 0); }
  bool stands_by() const { return !done() && steps_[current_].kind == StepKind::kStandBy; }
  /// Why the flight cannot go on; nullopt as long as it can.
  const std::optional<std::string>& failure() const { return failure_; }
  /// Whether it failed because the vehicle was disarmed before it had lifted off (arms_early).
  bool disarmed_before_takeoff() const { return disarmed_before_takeoff_; }
  /// The flight cannot go on for a reason that the plan does not see.
  void fail(std::string why) { failure_ = std::move(why); }
  /// The mission under way, once it is uploaded: where it goes and ends, and the item before its
  /// landing.
  void aim(const HomedMission& mission);
  /// Time of the next look at the vehicle, for callers who can choose it. After kLookPeriod if the
  /// vehicle's motion may complete the step; if only time completes it (hold, trajectory, the pause
  /// before a refused command is repeated) at its end, at the latest after kLongestLook.
  base::SimTime next_look(base::SimTime now) const;
  /// Reference position, north, east, up from the place of arming, and heading.
  const Eigen::Vector3d& reference_m() const { return reference_m_; }
  double reference_yaw_rad() const { return reference_yaw_rad_; }
  const std::vector<Stage>& stages() const { return stages_; }
  /// The step under way, for progress lines.
  const FlightStep* current() const { return done() ? nullptr : &steps_[current_]; }
  /// Phase of the flight, for conditions and the simulator's `flight_phase`: the step under
  /// way by its name or word, "done" after the last, nothing before the first.
  std::string_view phase() const;
  base::Duration elapsed_in_step(base::SimTime now) const { return now - step_begin_; }
  /// The step under way as a stage that goes up to now; nothing before it begins, and after the
  /// last.
  std::optional<Stage> under_way(base::SimTime now) const;
  /// The stage of the measured step; nothing before it is over.
  std::optional<Stage> measured() const;

 private:
  enum class Phase { kBegin, kCommanding, kWaiting };

  std::optional<base::SimTime> only_time_until() const;
  FlightStep in_vehicles_frame(FlightStep step) const;
  bool needs_command(const FlightStep& step, const VehicleReport& vehicle) const;
  bool lost_its_arming(const FlightStep& step, base::SimTime now,
                       const VehicleReport& vehicle) const;
  bool bides(const FlightStep& step, base::SimTime now, const VehicleReport& vehicle);
  bool reached(const FlightStep& step, base::SimTime now, const VehicleReport& vehicle,
               std::size_t others_through);
  void check_time(const FlightStep& step, base::SimTime now, const VehicleReport& vehicle);
  bool condition_holds(const FlightStep& step, base::SimTime now,
                       const VehicleReport& vehicle) const;
  bool hangs_still(base::SimTime now, const VehicleReport& vehicle);
  bool has_taken_off(base::SimTime now, const VehicleReport& vehicle);
  bool circles(base::SimTime now, const VehicleReport& vehicle);
  bool stays(base::SimTime now, bool still);
  bool has_landed_there(const VehicleReport& vehicle);
  bool has_returned(const FlightStep& step, base::SimTime now, const VehicleReport& vehicle);
  bool fence_took_over(const FlightStep& step, const VehicleReport& vehicle) const;
  bool has_flown_mission(const FlightStep& step, base::SimTime now, const VehicleReport& vehicle);
  bool is_at_last_item(const VehicleReport& vehicle) const;
  std::vector<std::string_view> modes_of(const FlightStep& step,
                                         const VehicleReport& vehicle) const;
  void check_mode(const FlightStep& step, base::SimTime now, const VehicleReport& vehicle);
  void begin_step(base::SimTime now, const FlightStep& step);
  void end_step(base::SimTime now);

  std::vector<FlightStep> steps_;
  FirmwareHabits habits_;
  std::size_t current_ = 0;
  Phase phase_ = Phase::kBegin;
  base::SimTime step_begin_;
  base::SimTime retry_at_;
  base::SimTime accepted_;
  std::optional<base::SimTime> still_since_;
  bool begun_ = false;
  bool takeoff_accepted_ = false;           ///< in the step under way
  bool lifted_off_ = false;                 ///< in the step under way, after it was accepted
  bool airborne_ = false;                   ///< between takeoff and land: disarming is a crash
  bool mode_seen_ = false;                  ///< in the step under way, the mode that flies it
  std::optional<std::uint16_t> last_item_;  ///< of the mission under way
  Eigen::Vector3d reference_m_ = Eigen::Vector3d::Zero();
  double reference_yaw_rad_ = 0;
  double circle_m_ = 0;
  bool on_wing_ = false;
  Eigen::Vector3d armed_at_N_ = Eigen::Vector3d::Zero();
  std::string last_refusal_;
  std::optional<std::string> failure_;
  bool disarmed_before_takeoff_ = false;
  std::vector<Stage> stages_;
};

}  // namespace cas::hils
