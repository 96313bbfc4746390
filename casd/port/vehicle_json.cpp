// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/vehicle_json.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/earth/deg_e7.hpp"
#include "base/enum_words.hpp"
#include "casd/port/call_json.hpp"

namespace cas::casd {
namespace {

using nlohmann::json;

template <class M>
double age_s(const Heard<M>& heard, base::RunTime now) {
  return base::to_seconds(now - heard.at);
}

bool all_finite(std::initializer_list<float> values) {
  return std::all_of(values.begin(), values.end(),
                     [](float value) { return std::isfinite(value); });
}

/// A vehicle that does not know its attitude or place sends NaN, which is no JSON number.
bool is_known(const mavlink::common::Attitude& a) {
  return all_finite({a.roll, a.pitch, a.yaw, a.rollspeed, a.pitchspeed, a.yawspeed});
}

bool is_known(const mavlink::common::LocalPositionNed& p) {
  return all_finite({p.x, p.y, p.z, p.vx, p.vy, p.vz});
}

json attitude_json(const Heard<mavlink::common::Attitude>& heard, base::RunTime now) {
  const mavlink::common::Attitude& attitude = heard.message;
  return json{{"roll_rad", attitude.roll},      {"pitch_rad", attitude.pitch},
              {"yaw_rad", attitude.yaw},        {"p_rad_s", attitude.rollspeed},
              {"q_rad_s", attitude.pitchspeed}, {"r_rad_s", attitude.yawspeed},
              {"age_s", age_s(heard, now)}};
}

json position_json(const Heard<mavlink::common::LocalPositionNed>& heard, base::RunTime now) {
  const mavlink::common::LocalPositionNed& local = heard.message;
  return json{{"x_m", local.x},
              {"y_m", local.y},
              {"z_m", local.z},
              {"vx_m_s", local.vx},
              {"vy_m_s", local.vy},
              {"vz_m_s", local.vz},
              {"age_s", age_s(heard, now)}};
}

json global_json(const Heard<mavlink::common::GlobalPositionInt>& heard, base::RunTime now) {
  const mavlink::common::GlobalPositionInt& here = heard.message;
  return json{{"lat_deg", base::degrees_of_e7(here.lat)},
              {"lon_deg", base::degrees_of_e7(here.lon)},
              {"alt_m", here.alt * 1e-3},
              {"relative_alt_m", here.relative_alt * 1e-3},
              {"age_s", age_s(heard, now)}};
}

/// HIGH_LATENCY2 has the altitude above mean sea level alone.
json global_json(const Heard<mavlink::common::HighLatency2>& heard,
                 const std::optional<HomeAmsl>& home, base::RunTime now) {
  const mavlink::common::HighLatency2& here = heard.message;
  json global{{"lat_deg", base::degrees_of_e7(here.latitude)},
              {"lon_deg", base::degrees_of_e7(here.longitude)},
              {"alt_m", here.altitude},
              {"age_s", age_s(heard, now)}};
  if (home) global["relative_alt_m"] = here.altitude - home->alt_m;
  return global;
}

json home_json(const HomeAmsl& home) {
  return json{{"lat_deg", home.lat_deg}, {"lon_deg", home.lon_deg}, {"alt_m", home.alt_m},
              {"x_m", home.x_m},         {"y_m", home.y_m},         {"z_m", home.z_m}};
}

json texts_json(const VehicleState& vehicle, base::RunTime now) {
  json texts = json::array();
  for (const StatusText& text : vehicle.status_texts()) {
    texts.push_back({{"severity", severity_word(text.severity)},
                     {"text", text.text},
                     {"age_s", base::to_seconds(now - text.at)}});
  }
  return texts;
}

std::string_view checks_word(ArmingChecks checks) {
  static constexpr base::EnumWords<ArmingChecks::kFail> kWords{"unknown", "pass", "fail"};
  return kWords[checks];
}

/// Reasons not to fly; empty: none.
json complaints_json(const VehicleState& vehicle, const LinkName& link_name, base::RunTime now) {
  json all = json::array();
  if (const std::optional<Rival> rival = vehicle.rival(now)) {
    all.push_back("another autopilot with this system id on link " +
                  link_name(rival->from.path.link));
  }
  for (std::string& complaint : complaints(vehicle, now)) all.push_back(std::move(complaint));
  return all;
}

}  // namespace

double moment_s(base::RunTime now) { return base::to_seconds(now.time_since_epoch()); }

std::string_view state_word(mavlink::common::MavState state) {
  using enum mavlink::common::MavState;
  switch (state) {
    case kBoot:
      return "boot";
    case kCalibrating:
      return "calibrating";
    case kStandby:
      return "standby";
    case kActive:
      return "active";
    case kCritical:
      return "critical";
    case kEmergency:
      return "emergency";
    case kPoweroff:
      return "poweroff";
    case kFlightTermination:
      return "flight_termination";
    default:
      return "uninit";
  }
}

json summary_json(const VehicleState& vehicle, const LinkName& link_name, base::RunTime now) {
  json summary{{"system", vehicle.source().system},
               {"component", vehicle.source().component},
               {"autopilot", name(vehicle.autopilot())},
               {"type", type_word(vehicle.type())},
               {"armed", vehicle.armed()},
               {"hil", vehicle.hil()},
               {"mode", vehicle.mode()},
               {"state", state_word(vehicle.heartbeat().message.system_status)},
               {"arming_checks", checks_word(arming_checks(vehicle, now))},
               {"landed", vehicle.landed_word()},
               {"link", link_name(vehicle.link())},
               {"heartbeat_age_s", base::to_seconds(vehicle.heartbeat_age(now))},
               {"silent_after_s", base::to_seconds(vehicle.silent_after())},
               {"complaints", complaints_json(vehicle, link_name, now)}};
  if (std::string lack = position_lack(vehicle, now); !lack.empty()) {
    summary["position_lacks"] = std::move(lack);
  }
  if (const std::optional<Rival> rival = vehicle.rival(now)) {
    summary["rival"] = {{"component", rival->source.component},
                        {"link", link_name(rival->from.path.link)},
                        {"heartbeat_age_s", base::to_seconds(now - rival->at)}};
  }
  return summary;
}

json state_json(const VehicleState& vehicle, const LinkName& link_name, base::RunTime now) {
  json state = summary_json(vehicle, link_name, now);
  if (vehicle.attitude() && is_known(vehicle.attitude()->message)) {
    state["attitude"] = attitude_json(*vehicle.attitude(), now);
  }
  if (vehicle.local_position() && is_known(vehicle.local_position()->message)) {
    state["position_N"] = position_json(*vehicle.local_position(), now);
  }
  const std::optional<HomeAmsl> home = vehicle.home();
  if (vehicle.is_high_latency()) {
    state["global"] = global_json(*vehicle.high_latency(), home, now);
  } else if (vehicle.global_position()) {
    state["global"] = global_json(*vehicle.global_position(), now);
  }
  if (home) state["home"] = home_json(*home);
  if (const auto altitude = vehicle.altitude()) {
    state["altitude_m"] = altitude->message;
    state["altitude_age_s"] = age_s(*altitude, now);
  }
  if (std::string version = vehicle.firmware_version(); !version.empty()) {
    state["firmware"] = std::move(version);
  }
  if (const std::string_view vtol = vehicle.vtol_word(); !vtol.empty()) state["vtol"] = vtol;
  if (const auto at = vehicle.landed_at()) state["landed_age_s"] = base::to_seconds(now - *at);
  state["at_s"] = moment_s(now);
  state["statustexts"] = texts_json(vehicle, now);
  return state;
}

json interventions_json(const Interventions& interventions, const LinkName& link_name,
                        base::RunTime now) {
  json all = json::array();
  for (const Intervention& each : interventions.all()) {
    all.push_back({{"by", std::to_string(each.by.system) + "/" + std::to_string(each.by.component)},
                   {"link", link_name(each.link)},
                   {"what", each.act.what},
                   {"disarms", each.act.disarms},
                   {"times", each.times},
                   {"age_s", base::to_seconds(now - each.at)}});
  }
  return all;
}

}  // namespace cas::casd
