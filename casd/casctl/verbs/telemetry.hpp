// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace cas::casctl {

/// One topic of vehicle.telemetry with its values in the order in which they are shown. The unit is
/// the end of a key: "roll_deg", "north_m_s".
struct TelemetryTopic {
  std::string name;
  std::vector<std::string> keys;
  bool is_usual = false;  ///< shown where no topic is named
};

/// All topics there are.
const std::vector<TelemetryTopic>& telemetry_topics();
std::vector<std::string> telemetry_topic_names();
/// The topics of these names, in their order; of no names the usual ones.
std::vector<TelemetryTopic> chosen_topics(const std::vector<std::string>& names);

/// An answer of vehicle.telemetry and when it came.
struct TelemetrySample {
  nlohmann::json answer;
  double time_s = 0;  ///< since the first sample was due
  double unix_s = 0;  ///< of the wall clock
};

/// One JSON object in one line: {"time_s", "unix_s", "vehicle", TOPIC: {...}}.
std::string json_line(const TelemetrySample& sample, const std::vector<TelemetryTopic>& topics);
/// "time_s,unix_s,vehicle,attitude_roll_deg,...,attitude_age_s".
std::string csv_header(const std::vector<TelemetryTopic>& topics);
/// The values of the header's columns; one that is not known is empty.
std::string csv_line(const TelemetrySample& sample, const std::vector<TelemetryTopic>& topics);
/// For people, a line for each topic. Values older than a second or two are marked with their age.
std::string text_lines(const TelemetrySample& sample, const std::vector<TelemetryTopic>& topics);

}  // namespace cas::casctl
