// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/strike_response.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "base/time/clock.hpp"
#include "casd/station/vehicle_state.hpp"
#include "casd/tlog/tlog_packets.hpp"
#include "hils/measure/incident.hpp"
#include "hils/measure/run_record.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/statustext.hpp"
#include "mavlink/common/sys_status.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::hils {

using namespace mavlink::common;  // NOLINT: the file is about its messages

namespace {

/// Higher than this above where it stood, a vehicle is in the air; lower than the second it is on
/// the ground, be it on its side.
constexpr double kInAir_m = 0.5;
constexpr double kDown_m = 0.3;
constexpr double kStill_m_s = 0.2;
/// A HEARTBEAT tells of what happened since the one before.
constexpr double kHeartbeat_s = 1.0;

struct HealthFlag {
  MavSysStatusSensor flag;
  std::string_view name;
};
constexpr std::array<HealthFlag, 12> kHealthFlags{
    {{MavSysStatusSensor::k3dGyro, "gyro"},
     {MavSysStatusSensor::k3dAccel, "accelerometer"},
     {MavSysStatusSensor::k3dMag, "compass"},
     {MavSysStatusSensor::kAbsolutePressure, "barometer"},
     {MavSysStatusSensor::kGps, "GPS"},
     {MavSysStatusSensor::kAhrs, "attitude estimate"},
     {MavSysStatusSensor::kYawPosition, "heading"},
     {MavSysStatusSensor::kZAltitudeControl, "height"},
     {MavSysStatusSensor::kXyPositionControl, "position"},
     {MavSysStatusSensor::kMotorOutputs, "motors"},
     {MavSysStatusSensor::kBattery, "battery"},
     {MavSysStatusSensor::kPrearmCheck, "arming checks"}}};

/// Goes through a flight log and notes what the vehicle told.
class TaleReader {
 public:
  explicit TaleReader(const RunRecord& record) : record_(record) {}

  void on_packet(std::int64_t log_us, const mav::PacketView& packet) {
    constexpr std::uint8_t kAutopilot = 1;
    if (packet.source.system != record_.system || packet.source.component != kAutopilot) return;
    now_s_ = 1e-6 * static_cast<double>(record_.log_clock.to_sim_us(log_us));
    if (const auto beat = mav::decode<Heartbeat>(packet)) on_heartbeat(*beat);
    if (const auto text = mav::decode<Statustext>(packet)) on_text(*text);
    if (const auto status = mav::decode<SysStatus>(packet)) on_status(*status);
  }

  VehicleTale finish() { return std::move(tale_); }

 private:
  void on_heartbeat(const Heartbeat& beat) {
    const bool armed = has(beat.base_mode, MavModeFlag::kSafetyArmed);
    if (armed != armed_) tale_.armed.push_back({now_s_, armed});
    armed_ = armed;
    const bool critical = beat.system_status == MavState::kCritical ||
                          beat.system_status == MavState::kEmergency ||
                          beat.system_status == MavState::kFlightTermination;
    const auto autopilot = casd::autopilot_family(beat.autopilot);
    const std::string mode = mode_name(autopilot, beat.base_mode, beat.custom_mode);
    if (critical && (!critical_ || mode != mode_)) {
      tale_.signs.push_back({.time_s = now_s_, .what = mode, .is_reaction = true});
    }
    critical_ = critical;
    mode_ = mode;
  }

  void on_text(const Statustext& message) {
    if (message.severity > MavSeverity::kWarning) return;
    std::string text(mav::text(message.text));
    std::ranges::replace_if(
        text, [](char c) { return c < ' ' || c > '~'; }, '?');
    tale_.signs.push_back({.time_s = now_s_, .what = "'" + text + "'"});
  }

  void on_status(const SysStatus& status) {
    std::string fallen;
    for (const auto& [flag, name] : kHealthFlags) {
      if (flag == MavSysStatusSensor::kPrearmCheck && armed_) continue;
      const bool fell = has(healthy_, flag) && !has(status.onboard_control_sensors_health, flag);
      if (fell) fallen += (fallen.empty() ? "" : ", ") + std::string(name);
    }
    healthy_ = status.onboard_control_sensors_health;
    if (!fallen.empty()) tale_.signs.push_back({.time_s = now_s_, .what = "health: " + fallen});
  }

  const RunRecord& record_;
  double now_s_ = 0;
  bool armed_ = false;
  bool critical_ = false;
  std::string mode_;
  MavSysStatusSensor healthy_{};
  VehicleTale tale_;
};

Eigen::Vector3d place(const PoseSample& sample, const PoseSample& start) {
  return {sample.pose.x_m - start.pose.x_m, sample.pose.y_m - start.pose.y_m,
          sample.pose.z_m - start.pose.z_m};
}

/// Angle between the vehicle's axis and the vertical.
double tilt_deg(const Pose& pose) {
  const double upright = std::cos(pose.roll_rad) * std::cos(pose.pitch_rad);
  return std::acos(std::clamp(upright, -1.0, 1.0)) * 180 / M_PI;
}

/// The lines between the places of a plan, from the start to the landing.
class PlannedPath {
 public:
  explicit PlannedPath(std::span<const FlightStep> steps) {
    for (const FlightStep& step : steps) {
      if (step.kind == StepKind::kTakeoff) places_.emplace_back(0, 0, step.altitude_m);
      if (step.kind == StepKind::kGoto) places_.push_back(step.place_m);
      if (step.kind == StepKind::kTrajectory) slack_m_ = std::max(slack_m_, step.trajectory.size_m);
      if (step.kind == StepKind::kLand) {
        places_.emplace_back(places_.back().x(), places_.back().y(), 0);
      }
    }
  }

  double distance_m(const Eigen::Vector3d& p) const {
    double least = (p - places_.front()).norm();
    for (std::size_t i = 1; i < places_.size(); ++i) {
      const Eigen::Vector3d along = places_[i] - places_[i - 1];
      const double length2 = along.squaredNorm();
      const double share =
          length2 > 0 ? std::clamp((p - places_[i - 1]).dot(along) / length2, 0.0, 1.0) : 0.0;
      least = std::min(least, (p - places_[i - 1] - share * along).norm());
    }
    return std::max(0.0, least - slack_m_);
  }

 private:
  std::vector<Eigen::Vector3d> places_{Eigen::Vector3d::Zero()};
  double slack_m_ = 0;  ///< trajectories fly about their place
};

bool is_crash(IncidentKind kind) { return kind != IncidentKind::kGround; }

std::int64_t microseconds(double time_s) { return std::llround(time_s * 1e6); }

void look_at_motion(const StrikeEvidence& evidence, StrikeResponse& response) {
  if (evidence.truth.empty()) return;
  const PoseSample& start = evidence.truth.front();
  const PoseSample& last = evidence.truth.back();
  const PlannedPath path(evidence.steps);
  const auto after = between(evidence.truth, microseconds(evidence.strike_s), last.time_us + 1);
  bool flew = false;
  bool down = false;
  for (const PoseSample& sample : after) {
    const Eigen::Vector3d p = place(sample, start);
    response.farthest_m = std::max(response.farthest_m, path.distance_m(p));
    flew |= p.z() > kInAir_m;
    down |= flew && p.z() < kDown_m / 2;
    if (!down) response.peak_tilt_deg = std::max(response.peak_tilt_deg, tilt_deg(sample.pose));
  }
  for (const Incident& incident :
       find_incidents({evidence.stages.begin(), evidence.stages.end()}, evidence.truth)) {
    if (incident.time_s < evidence.strike_s) continue;
    if (!response.incident) response.incident = incident.kind;
    response.crashed |= is_crash(incident.kind);
  }
  const Eigen::Vector3d end = place(last, start);
  const double speed = std::hypot(last.v_m_s[0], last.v_m_s[1], last.v_m_s[2]);
  response.at_rest = end.z() < kDown_m && speed < kStill_m_s;
  response.crashed |= -last.v_m_s[2] > kCrashSpeed_m_s;
  if (!after.empty()) {
    response.rest_m = (end - place(after.front(), start)).head<2>().norm();
  }
}

/// Whether the vehicle was in the air shortly before a moment.
bool was_in_air(const StrikeEvidence& evidence, double time_s) {
  if (evidence.truth.empty()) return false;
  const PoseSample& start = evidence.truth.front();
  return std::ranges::any_of(
      between(evidence.truth, microseconds(time_s - kHeartbeat_s), microseconds(time_s)),
      [&start](const PoseSample& sample) { return place(sample, start).z() > kInAir_m; });
}

void note(const StrikeEvidence& evidence, const VehicleSign& sign, StrikeResponse& response) {
  const double after_s = sign.time_s - evidence.strike_s;
  if (!response.detected_s || after_s < *response.detected_s) {
    response.detected_s = after_s;
    response.detected_by = sign.what;
  }
  if (!sign.is_reaction) return;
  if (!response.reacted_s || after_s < *response.reacted_s) {
    response.reacted_s = after_s;
    response.reaction = sign.what;
  }
}

}  // namespace

VehicleTale read_vehicle_tale(const RunRecord& record) {
  TaleReader reader(record);
  casd::for_each_tlog_packet(record.flight_tlog, table(),
                             [&](std::uint64_t unix_us, const mav::PacketView& packet) {
                               reader.on_packet(static_cast<std::int64_t>(unix_us), packet);
                             });
  return reader.finish();
}

StrikeResponse strike_response(const StrikeEvidence& evidence) {
  StrikeResponse response{
      .strike_s = evidence.strike_s, .fault = evidence.fault, .completed = evidence.completed};
  look_at_motion(evidence, response);
  for (const VehicleSign& sign : evidence.tale.signs) {
    if (sign.time_s < evidence.strike_s) continue;
    note(evidence, sign, response);
    response.terminated |= sign.is_reaction && sign.what == "TERMINATION";
  }
  for (const auto& [time_s, armed] : evidence.tale.armed) {
    if (time_s < evidence.strike_s) {
      response.armed_before = armed;
      continue;
    }
    response.armed_after |= armed;
    if (armed || !was_in_air(evidence, time_s)) continue;
    response.terminated = true;
    note(evidence, {.time_s = time_s, .what = "disarmed in the air", .is_reaction = true},
         response);
  }
  response.armed_after |= response.armed_before;
  return response;
}

std::optional<StrikeResponse> read_strike_response(const RunRecord& record,
                                                   std::span<const FlightStep> steps,
                                                   std::span<const PoseSample> truth) {
  const auto first = std::ranges::min_element(record.faults, {}, &BenchFaultScript::Span::begin);
  if (first == record.faults.end()) return std::nullopt;
  std::vector<Stage> stages = record.stages;
  if (record.under_way) stages.push_back(*record.under_way);
  return strike_response({.strike_s = base::to_seconds(first->begin),
                          .fault = first->name,
                          .stages = stages,
                          .steps = steps,
                          .completed = record.flight_failure.empty(),
                          .truth = truth,
                          .tale = read_vehicle_tale(record)});
}

}  // namespace cas::hils
