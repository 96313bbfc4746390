// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "base/earth/geodesy.hpp"
#include "hils/ulog/read_ulog.hpp"

namespace cas::hils {

/// The true motion and the position setpoints in a vehicle's own log.
///
/// Truth comes from the simulator, through the autopilot: vehicle_local_position_groundtruth with
/// the newest vehicle_attitude_groundtruth, vehicle_angular_velocity_groundtruth and rotor_speeds
/// (a topic of CAS). Setpoints are vehicle_local_position_setpoint: north, east, down from the
/// origin of the estimator.
class UlogTruth {
 public:
  /// @param t_s  time since the begin of the log
  void on_message(double t_s, const UlogSeries& series, std::string_view bytes);

  /// Adds these, if the log has them:
  ///   truth, reference: as a run's record has them
  ///   origin: (east, north, up) of the estimator's origin from that of the truth, m; only if both
  ///           have a place on Earth. Without it the page takes the first true position
  void add_to(nlohmann::ordered_json& vehicle) const;

 private:
  void on_true_position(double t_s, const UlogSeries& series, std::string_view bytes);
  void on_setpoint(double t_s, const UlogSeries& series, std::string_view bytes);
  /// Place of the estimator's origin in the axes of the truth.
  Eigen::Vector3d origin_W() const;

  std::vector<std::vector<double>> truth_;  ///< rows of truth.csv
  std::vector<std::array<double, 5>>
      setpoints_;  ///< rows of ReferenceColumns, from the estimator's origin
  std::optional<Eigen::Quaterniond> q_ND_;
  Eigen::Vector3d w_D_{0, 0, 0};
  std::optional<base::Geodetic> true_home_;
  std::optional<base::Geodetic> estimator_home_;
};

}  // namespace cas::hils
