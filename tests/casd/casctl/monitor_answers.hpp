// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace cas::casctl {

/// Answers of casd, as the monitor gets them.
inline nlohmann::json link_answer(const std::string& name, int rx, int tx,
                                  const std::string& state = "up",
                                  const std::string& endpoint = "127.0.0.1:24560") {
  return {{"name", name},
          {"type", "udp"},
          {"state", state},
          {"endpoint", endpoint},
          {"rx", {{"packets", rx}, {"lost", 0}, {"crc_errors", 0}}},
          {"tx",
           {{"packets", tx},
            {"dropped", {{"age", 0}}},
            {"queue_high_water", 1},
            {"forwarding_us", {{"p99", 60.0}}}}}};
}

inline nlohmann::json message_answer(const std::string& link, const std::string& direction, int id,
                                     const std::string& name, double hz) {
  return {{"link", link}, {"direction", direction}, {"id", id},    {"name", name},
          {"system", 1},  {"component", 1},         {"count", 10}, {"hz", hz},
          {"age_s", 0.1}};
}

inline nlohmann::json vehicle_answer(double heartbeat_age_s = 0.3) {
  return {{"system", 1},
          {"component", 1},
          {"autopilot", "PX4"},
          {"type", "quadrotor"},
          {"armed", true},
          {"hil", true},
          {"mode", "HOLD"},
          {"state", "active"},
          {"landed", "in_air"},
          {"link", "fcu"},
          {"heartbeat_age_s", heartbeat_age_s},
          {"complaints", nlohmann::json::array()}};
}

inline nlohmann::json state_answer() {
  nlohmann::json state = vehicle_answer();
  state["altitude_m"] = 2.52;
  state["statustexts"] = nlohmann::json::array(
      {{{"severity", "info"}, {"text", "Ready for takeoff!"}, {"age_s", 20.0}},
       {{"severity", "critical"}, {"text", "Failsafe activated, stick input"}, {"age_s", 4.2}}});
  return state;
}

inline nlohmann::json telemetry_answer(double age_s = 0.05) {
  return {
      {"vehicle", 1},
      {"attitude", {{"roll_deg", 12.3}, {"pitch_deg", -4.5}, {"yaw_deg", 91.0}, {"age_s", age_s}}},
      {"position", {{"north_m", 1.25}, {"east_m", -3.5}, {"down_m", -2.52}, {"age_s", age_s}}},
      {"velocity", {{"north_m_s", 0.1}, {"east_m_s", 0.2}, {"down_m_s", 0.3}, {"age_s", age_s}}},
      {"global",
       {{"lat_deg", 47.3977421},
        {"lon_deg", 8.5455938},
        {"alt_m", 490.5},
        {"relative_alt_m", 2.5},
        {"heading_deg", 91.0},
        {"age_s", age_s}}},
      {"battery",
       {{"voltage_v", 16.12}, {"current_a", 14.2}, {"remaining_percent", 91}, {"age_s", age_s}}},
      {"gps", {{"fix", "3d"}, {"satellites", 12}, {"age_s", age_s}}}};
}

inline nlohmann::json attitude_answer(double roll) {
  return {{"id", 30},
          {"name", "ATTITUDE"},
          {"age_s", 0.0},
          {"count", 1},
          {"fields", nlohmann::json::array(
                         {{{"name", "time_boot_ms"}, {"value", 29970}, {"units", "ms"}},
                          {{"name", "roll"}, {"value", roll}, {"units", "rad"}},
                          {{"name", "pitch"}, {"value", 0.25}, {"units", "rad"}},
                          {{"name", "controls"}, {"value", {0.5, 0.25, 0, 1, 2, 3, 4, 5}}}})}};
}

}  // namespace cas::casctl
