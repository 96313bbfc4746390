// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/companion_flight.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/angles.hpp"
#include "base/error.hpp"
#include "base/rpc/client.hpp"
#include "mavlink/common/enums.hpp"

namespace cas::hils {
namespace {

/// PX4 v1.12 and v1.16 enter OFFBOARD while setpoints come; this is twice their window.
constexpr base::Duration kLead = std::chrono::seconds(1);
/// For which sticks are centred before another mode.
constexpr base::Duration kRest = std::chrono::milliseconds(500);
/// In real time, of a simulation that may run slower than that.
constexpr base::Duration kLeadPatience = std::chrono::seconds(30);
constexpr base::Duration kGlance = std::chrono::milliseconds(5);
constexpr const char* kTellsNoTime = "the vehicle does not tell its time";

bool is_ardupilot(const CompanionFlight::Vehicle& vehicle) {
  return vehicle.autopilot == "ArduPilot";
}

/// The parameters of a call that moves the vehicle.
nlohmann::json consenting(nlohmann::json params, const CompanionFlight::Vehicle& vehicle) {
  if (vehicle.not_hil) params["not_hil"] = true;
  return params;
}

/// From the air straight to a place, north, east, up from home.
MissionPlan mission_to(const Eigen::Vector3d& place_m, double speed_m_s) {
  constexpr float kGroundSpeed = 1;
  MissionPlan plan;
  plan.items.push_back({.command = mavlink::common::MavCmd::kDoChangeSpeed,
                        .frame = mavlink::common::MavFrame::kMission,
                        .params = {kGroundSpeed, static_cast<float>(speed_m_s), -1, 0}});
  plan.items.push_back({.command = mavlink::common::MavCmd::kNavWaypoint,
                        .local = true,
                        .north = place_m.x(),
                        .east = place_m.y(),
                        .up_m = place_m.z()});
  return plan;
}

/// "127.0.0.1:34567"
std::uint16_t port_of(const std::string& endpoint) {
  return static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1)));
}

}  // namespace

bool CompanionFlight::gives(StepKind kind) {
  return kind == StepKind::kTrajectory || kind == StepKind::kEndTrajectory ||
         kind == StepKind::kSticks || kind == StepKind::kMission || kind == StepKind::kBreach;
}

void CompanionFlight::join(const std::string& name) {
  const nlohmann::json state = call_("vehicle.state", nlohmann::json::object());
  for (const nlohmann::json& link : call_("link.list", nlohmann::json::object())) {
    if (link.value("name", "") != name) continue;
    const mav::Source vehicle{.system = state.at("system").get<std::uint8_t>(),
                              .component = state.at("component").get<std::uint8_t>()};
    return link_.connect(port_of(link.at("endpoint").get<std::string>()), vehicle);
  }
  throw base::ConfigError("casd has no link " + name);
}

void CompanionFlight::before_look() {
  if (!link_.connected()) return;
  time_before_look_ =
      link_.with_station([](const auto& station) { return station.vehicle_time(); });
}

void CompanionFlight::after_look(base::SimTime now) {
  if (time_before_look_) clock_.add(*time_before_look_, now);
}

CompanionFlight::Answer CompanionFlight::give(const FlightStep& step, const Vehicle& vehicle) {
  if (vehicle.autopilot != "PX4" && !is_ardupilot(vehicle)) {
    return {.refusal = "only PX4 and ArduPilot fly trajectories, missions and to a fence",
            .for_good = true};
  }
  try {
    if (step.kind == StepKind::kTrajectory) return begin_trajectory(step, vehicle);
    if (step.kind == StepKind::kSticks) return begin_sticks(step, vehicle);
    if (step.kind == StepKind::kEndTrajectory) {
      return step.sticks ? end_sticks() : end_trajectory(vehicle);
    }
    if (step.kind == StepKind::kBreach) return begin_breach(step, vehicle);
    return fly_mission(step.mission, vehicle);
  } catch (const base::rpc::CallError& error) {
    return {.refusal = error.what()};
  }
}

/// PX4 takes POSCTL once sticks come; until then it is asked again. ArduCopter takes LOITER at once
/// and sinks by the throttle of a transmitter that is not there: centred sticks come first.
CompanionFlight::Answer CompanionFlight::begin_sticks(const FlightStep& step,
                                                      const Vehicle& vehicle) {
  ask_for_position();
  if (is_ardupilot(vehicle) && !centres_sticks()) return {.refusal = kTellsNoTime};
  link_.with_station([&](auto& station) { station.sticks().hold(*step.sticks); });
  call_("vehicle.mode",
        consenting({{"mode", is_ardupilot(vehicle) ? "LOITER" : "POSCTL"}}, vehicle));
  return {};
}

/// A stick that moves brings PX4 back from HOLD to POSCTL (COM_RC_OVERRIDE): they rest first.
CompanionFlight::Answer CompanionFlight::end_sticks() {
  if (!centres_sticks()) return {.refusal = kTellsNoTime};
  call_("vehicle.hold", nlohmann::json::object());
  return {};
}

/// Centres the sticks and waits. @return whether the vehicle's clock went on meanwhile
bool CompanionFlight::centres_sticks() {
  link_.with_station([](auto& station) { station.sticks().hold({}); });
  return comes_to([](auto& station) { return station.sticks().held_for() >= kRest; });
}

/// Setpoints come first: PX4 refuses OFFBOARD without them. @return why not
std::optional<std::string> CompanionFlight::enter_stream(const Vehicle& vehicle) {
  ask_for_position();
  link_.with_station(
      [&](auto& station) { station.setpoints().hover(vehicle.hover_N, vehicle.yaw_rad); });
  if (!streams()) return "the vehicle does not tell its position, nor its time";
  call_("vehicle.mode",
        consenting({{"mode", is_ardupilot(vehicle) ? "GUIDED" : "OFFBOARD"}}, vehicle));
  return std::nullopt;
}

CompanionFlight::Answer CompanionFlight::begin_trajectory(const FlightStep& step,
                                                          const Vehicle& vehicle) {
  if (const auto why = enter_stream(vehicle)) return {.refusal = why};
  const base::Duration begin = link_.with_station([&](auto& station) {
    station.setpoints().fly(step.trajectory.pattern(), *station.vehicle_time());
    return *station.vehicle_time();
  });
  Answer answer;
  if (!clock_.empty()) answer.begin = clock_.to_sim(begin);
  return answer;
}

/// Flies back to the middle and stays there in HOLD (ArduCopter: GUIDED). PX4 gets setpoints until
/// it accepts the command, because it takes their end for a lost companion. ArduCopter obeys the
/// last packet, so its setpoints end before the command: a delayed setpoint must not undo it.
CompanionFlight::Answer CompanionFlight::end_trajectory(const Vehicle& vehicle) {
  const auto stop = [this] {
    link_.with_station([](auto& station) { station.setpoints().stop(); });
  };
  link_.with_station(
      [&](auto& station) { station.setpoints().hover(vehicle.hover_N, vehicle.yaw_rad); });
  if (is_ardupilot(vehicle)) stop();
  call_("vehicle.goto", consenting({{"north_m", vehicle.hover_N.x()},
                                    {"east_m", vehicle.hover_N.y()},
                                    {"down_m", vehicle.hover_N.z()},
                                    {"yaw_deg", vehicle.yaw_rad * base::kDegPerRad}},
                                   vehicle));
  stop();
  return {};
}

/// ArduCopter 4.5 takes no setpoint beyond its fence, PX4 no mission.
CompanionFlight::Answer CompanionFlight::begin_breach(const FlightStep& step,
                                                      const Vehicle& vehicle) {
  if (is_ardupilot(vehicle)) {
    Answer answer = fly_mission(mission_to(step.place_m, step.trajectory.speed_m_s), vehicle);
    answer.mission.reset();  // its end is no place of the plan
    return answer;
  }
  if (const auto why = enter_stream(vehicle)) return {.refusal = why};
  const Eigen::Vector3d place_N =
      vehicle.armed_at_N + Eigen::Vector3d(step.place_m.x(), step.place_m.y(), -step.place_m.z());
  link_.with_station([&](auto& station) {
    station.setpoints().fly_to(place_N, step.trajectory.speed_m_s, *station.vehicle_time());
  });
  breaching_ = true;
  return {};
}

void CompanionFlight::lose_sticks(bool lost) {
  if (!link_.connected()) return;
  link_.with_station([lost](auto& station) { station.sticks().lose(lost); });
}

void CompanionFlight::end_breach() {
  if (!std::exchange(breaching_, false)) return;
  link_.with_station([](auto& station) { station.setpoints().stop(); });
}

CompanionFlight::Answer CompanionFlight::fly_mission(const MissionPlan& plan,
                                                     const Vehicle& vehicle) {
  const nlohmann::json state = call_("vehicle.state", nlohmann::json::object());
  const auto home = state.find("home");
  if (home == state.end()) return {.refusal = "the vehicle has not told its home yet"};
  Answer answer;
  answer.mission = at_home(
      plan, {home->value("lat_deg", 0.0), home->value("lon_deg", 0.0), home->value("alt_m", 0.0)},
      is_ardupilot(vehicle));
  if (const auto uploaded = upload(*answer.mission); !uploaded.ok()) {
    return {.refusal = "the mission was not taken: " + uploaded.message, .for_good = true};
  }
  if (is_ardupilot(vehicle)) {
    // From the ground AUTO alone waits for a raised throttle.
    const nlohmann::json start{
        {"command", static_cast<int>(mavlink::common::MavCmd::kMissionStart)}, {"params", {0, 0}}};
    call_("vehicle.command", consenting(start, vehicle));
  } else {
    call_("vehicle.mode", consenting({{"mode", "MISSION"}}, vehicle));
  }
  return answer;
}

mav::services::Outcome CompanionFlight::upload(const HomedMission& mission) {
  link_.with_station([&](auto& station) { station.upload(mission.items, base::steady_now()); });
  while (true) {
    const auto outcome = link_.with_station([](const auto& station) { return station.uploaded(); });
    if (outcome) return *outcome;
    wait_(kGlance);
  }
}

/// A vehicle that refuses goes on at its own rate.
void CompanionFlight::ask_for_position() {
  if (std::exchange(asked_for_position_, true)) return;
  try {
    call_("vehicle.message_interval",
          {{"message", "LOCAL_POSITION_NED"}, {"hz", SetpointStream::kRate_hz}});
  } catch (const base::rpc::CallError&) {
  }
}

bool CompanionFlight::streams() {
  return comes_to([](const auto& station) { return station.setpoints().alive_for() >= kLead; });
}

template <class Holds>
bool CompanionFlight::comes_to(Holds&& holds) {
  const base::RunTime deadline = base::steady_now() + kLeadPatience;
  while (!link_.with_station(holds)) {
    if (base::steady_now() > deadline) return false;
    wait_(kGlance);
  }
  return true;
}

std::optional<std::uint16_t> CompanionFlight::reached() {
  if (!link_.connected()) return std::nullopt;
  return link_.with_station([](const auto& station) { return station.reached(); });
}

SetpointFigures CompanionFlight::setpoints() {
  if (!link_.connected()) return {};
  return link_.with_station([](const auto& station) { return station.setpoints().figures(); });
}

}  // namespace cas::hils
