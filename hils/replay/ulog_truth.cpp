// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/ulog_truth.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/earth/frames.hpp"
#include "hils/replay/reference_columns.hpp"
#include "hils/replay/truth_columns.hpp"

namespace cas::hils {

namespace {

double number(const UlogSeries& series, std::string_view bytes, std::string_view field) {
  const auto found = std::ranges::find(series.fields, field, &UlogField::name);
  return found == series.fields.end() ? std::nan("") : ulog_number(*found, bytes);
}

/// Where the origin of local positions is on Earth, if the message says so.
std::optional<base::Geodetic> home_of(const UlogSeries& series, std::string_view bytes) {
  const base::Geodetic home{number(series, bytes, "ref_lat"), number(series, bytes, "ref_lon"),
                            number(series, bytes, "ref_alt")};
  const bool is_valid = number(series, bytes, "xy_global") == 1 &&
                        number(series, bytes, "z_global") == 1 && std::abs(home.lat_deg) <= 90 &&
                        std::abs(home.lon_deg) <= 180 && std::isfinite(home.alt_m);
  return is_valid ? std::optional(home) : std::nullopt;
}

std::vector<double> rotor_speeds(const UlogSeries& series, std::string_view bytes) {
  std::vector<double> speeds;
  for (const UlogField& field : series.fields) {
    if (field.name.starts_with("omega_rad_s[")) speeds.push_back(ulog_number(field, bytes));
  }
  return speeds;
}

}  // namespace

void UlogTruth::on_message(double t_s, const UlogSeries& series, std::string_view bytes) {
  const auto value = [&](std::string_view field) { return number(series, bytes, field); };
  if (series.name == "vehicle_local_position_groundtruth") {
    on_true_position(t_s, series, bytes);
  } else if (series.name == "vehicle_attitude_groundtruth") {
    const Eigen::Quaterniond q(value("q[0]"), value("q[1]"), value("q[2]"), value("q[3]"));
    const bool is_attitude = std::abs(q.norm() - 1) < 0.1;  // also false for NaN
    if (is_attitude) q_ND_ = q.normalized();
  } else if (series.name == "vehicle_angular_velocity_groundtruth") {
    w_D_ = {value("xyz[0]"), value("xyz[1]"), value("xyz[2]")};
  } else if (series.name == "rotor_speeds") {
    if (truth_.empty() || truth_.back().size() > TruthColumns::kMotion) return;
    const std::vector<double> speeds = rotor_speeds(series, bytes);
    truth_.back().insert(truth_.back().end(), speeds.begin(), speeds.end());
  } else if (series.name == "vehicle_local_position") {
    if (!estimator_home_) estimator_home_ = home_of(series, bytes);
  } else if (series.name == "vehicle_local_position_setpoint") {
    on_setpoint(t_s, series, bytes);
  }
}

void UlogTruth::on_true_position(double t_s, const UlogSeries& series, std::string_view bytes) {
  const auto value = [&](std::string_view field) { return number(series, bytes, field); };
  if (!true_home_) true_home_ = home_of(series, bytes);
  if (!q_ND_) return;
  const Eigen::Vector3d rpy = base::euler_rpy(*q_ND_);
  std::vector<double> row{t_s,         value("x"),   value("y"), -value("z"), value("vx"),
                          value("vy"), -value("vz"), rpy.x(),    rpy.y(),     rpy.z(),
                          w_D_.x(),    w_D_.y(),     w_D_.z()};
  if (std::ranges::all_of(row, [](double x) { return std::isfinite(x); })) {
    truth_.push_back(std::move(row));
  }
}

void UlogTruth::on_setpoint(double t_s, const UlogSeries& series, std::string_view bytes) {
  const auto value = [&](std::string_view field) { return number(series, bytes, field); };
  if (!setpoints_.empty() && t_s < setpoints_.back()[0] + ReferenceColumns::kPeriod_s) return;
  const std::array row{t_s, value("x"), value("y"), -value("z"), value("yaw")};
  // An axis without a position setpoint is no number.
  if (std::ranges::all_of(row, [](double x) { return std::isfinite(x); })) {
    setpoints_.push_back(row);
  }
}

Eigen::Vector3d UlogTruth::origin_W() const {
  if (true_home_ && estimator_home_) {
    return base::swap_WN(base::LocalProjection(*true_home_).to_local(*estimator_home_));
  }
  if (truth_.empty()) return {0, 0, 0};
  return {truth_[0][2], truth_[0][1], truth_[0][3]};  // the controller counts from its start
}

void UlogTruth::add_to(nlohmann::ordered_json& vehicle) const {
  const Eigen::Vector3d origin = origin_W();
  TruthColumns truth;
  for (const std::vector<double>& row : truth_) truth.add(row);
  ReferenceColumns reference;
  for (const auto& [t_s, north_m, east_m, up_m, yaw_rad] : setpoints_) {
    reference.add({t_s, north_m + origin.y(), east_m + origin.x(), up_m + origin.z(), yaw_rad});
  }
  vehicle["truth"] = truth.json();
  vehicle["reference"] = reference.json();
  vehicle["origin"] = {origin.x(), origin.y(), origin.z()};
}

}  // namespace cas::hils
