// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "fcu/flight/flight_tasks.hpp"

namespace cas::fcu {

/// Flies on the wing in each automatic mode: takes off from a runway, flies circles (hold), and
/// lands where it took off, in the same direction.
///
///   take-off: run -> climb      hold: circle      land, return: circle at the end of the slope
///                                                 -> slope -> flare -> roll out
class WingTask final : public FlightTask {
 public:
  /// The mode that the next activate() begins.
  void set_mode(FlightMode mode) { mode_ = mode; }
  /// Height of the take-off, z (down) in N; nullopt: MIS_TAKEOFF_ALT above the ground.
  void set_takeoff_z(std::optional<double> z) { takeoff_z_ = z; }
  /// Circles about a place. A coordinate that is NaN keeps its old value.
  /// @param radius_m  above 0 clockwise
  void circle(const Eigen::Vector3d& middle_N, double radius_m);

  void activate(const TaskContext& context) override;
  ControlSetpoint update(const TaskContext& context) override;
  void shift(const Eigen::Vector3d& by_N) override;
  /// The take-off has reached its height.
  bool done(const TaskContext& context) const override;
  bool wants_takeoff(const TaskContext&) const override { return mode_ == FlightMode::kTakeoff; }
  bool descending(const TaskContext&) const override { return stage_ >= Stage::kSlope; }
  /// Whether the vehicle has stood on the ground for a while after a landing.
  bool landed() const;

 private:
  enum class Stage { kRun, kClimb, kCircle, kToSlope, kSlope, kFlare };

  void begin_circle(const TaskContext& context);
  void begin_landing(const TaskContext& context);
  void advance(const TaskContext& context);
  bool meets_slope(const TaskContext& context) const;
  void run(const TaskContext& context, WingSetpoint& out) const;
  void descend(const TaskContext& context, WingSetpoint& out) const;
  void flare(const TaskContext& context, WingSetpoint& out) const;

  FlightMode mode_ = FlightMode::kHold;
  Stage stage_ = Stage::kCircle;
  Path path_;
  LinePath slope_;  // to the place of touchdown
  double z_m_ = 0;  // wanted height
  std::optional<double> takeoff_z_;
  double heading_rad_ = 0;
  double time_s_ = 0;   // in the stage
  double still_s_ = 0;  // on the ground
};

}  // namespace cas::fcu
