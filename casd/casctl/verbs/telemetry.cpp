// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/verbs/telemetry.hpp"

#include <algorithm>
#include <string_view>

#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

struct Unit {
  std::string_view ending;  ///< of a key
  std::string_view symbol;
  int decimals;
};

/// Longer endings before those that they end with.
constexpr Unit kUnits[] = {
    {"_deg_s", "deg/s", 2}, {"_m_s", "m/s", 2}, {"_percent", "%", 0}, {"_deg", "deg", 2},
    {"_us", "us", 0},       {"_m", "m", 2},     {"_v", "V", 2},       {"_a", "A", 2},
};
constexpr Unit kNoUnit{"", "", 2};
constexpr int kPlaceDecimals = 7;  // of latitude and longitude, as on the wire

const Unit& unit_of(std::string_view key) {
  const auto* const found = std::find_if(std::begin(kUnits), std::end(kUnits),
                                         [key](const Unit& u) { return key.ends_with(u.ending); });
  return found == std::end(kUnits) ? kNoUnit : *found;
}

/// The value, null where casd does not tell it.
json value_of(const json& answer, const std::string& topic, const std::string& key) {
  const auto found = answer.find(topic);
  if (found == answer.end() || !found->is_object()) return nullptr;
  return found->value(key, json());
}

std::string csv_cell(const json& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return value.dump();
  const auto text = value.get<std::string>();
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

/// "0.57 deg", "3d", "yes", "-".
std::string value_text(const std::string& key, const json& value) {
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_string()) return value.get<std::string>();
  const Unit& unit = unit_of(key);
  const bool is_place = key == "lat_deg" || key == "lon_deg";
  std::string text = "-";
  if (value.is_number_integer() && (unit.decimals == 0 || unit.symbol.empty())) {
    text = value.dump();
  } else if (value.is_number()) {
    text = fixed(value.get<double>(), is_place ? kPlaceDecimals : unit.decimals);
  }
  return unit.symbol.empty() ? text : text + " " + std::string(unit.symbol);
}

/// "roll 0.57 deg": the key without its unit.
std::string labelled(const std::string& key, const json& value) {
  std::string label = key.substr(0, key.size() - unit_of(key).ending.size());
  std::replace(label.begin(), label.end(), '_', ' ');
  return label + " " + value_text(key, value);
}

std::string values_text(const json& answer, const TelemetryTopic& topic) {
  const json age_s = value_of(answer, topic.name, "age_s");
  if (!age_s.is_number()) return "not heard yet";
  std::string text;
  for (const std::string& key : topic.keys) {
    const json value = value_of(answer, topic.name, key);
    if (topic.name == "rotors" && value.is_null()) continue;  // not driven
    text += (text.empty() ? "" : ", ") + labelled(key, value);
  }
  if (text.empty()) text = "nothing is driven";
  if (age_s.get<double>() > kStale_s) {
    text += "  (" + duration_text(age_s.get<double>()) + " old)";
  }
  return text;
}

}  // namespace

const std::vector<TelemetryTopic>& telemetry_topics() {
  static const std::vector<TelemetryTopic> kTopics{
      {"state", {"armed", "mode", "landed", "system_state"}, true},
      {"attitude", {"roll_deg", "pitch_deg", "yaw_deg"}, true},
      {"rates", {"roll_deg_s", "pitch_deg_s", "yaw_deg_s"}},
      {"position", {"north_m", "east_m", "down_m"}, true},
      {"velocity", {"north_m_s", "east_m_s", "down_m_s"}, true},
      {"global", {"lat_deg", "lon_deg", "alt_m", "relative_alt_m", "heading_deg"}},
      {"battery", {"voltage_v", "current_a", "remaining_percent"}, true},
      {"gps",
       {"fix", "satellites", "lat_deg", "lon_deg", "alt_m", "hdop", "vdop", "speed_m_s",
        "course_deg", "horizontal_accuracy_m", "vertical_accuracy_m"},
       true},
      {"estimator",
       {"attitude_ok", "horizontal_velocity_ok", "vertical_velocity_ok", "horizontal_position_ok",
        "height_ok", "gps_glitch", "accel_error", "velocity_ratio", "horizontal_position_ratio",
        "height_ratio", "mag_ratio", "horizontal_accuracy_m", "vertical_accuracy_m"}},
      {"rotors",
       {"output1_us", "output2_us", "output3_us", "output4_us", "output5_us", "output6_us",
        "output7_us", "output8_us"}},
  };
  return kTopics;
}

std::vector<std::string> telemetry_topic_names() {
  std::vector<std::string> names;
  for (const TelemetryTopic& topic : telemetry_topics()) names.push_back(topic.name);
  return names;
}

std::vector<TelemetryTopic> chosen_topics(const std::vector<std::string>& names) {
  std::vector<TelemetryTopic> chosen;
  const auto is_chosen = [&chosen](const std::string& name) {
    return std::any_of(chosen.begin(), chosen.end(),
                       [&name](const TelemetryTopic& topic) { return topic.name == name; });
  };
  for (const std::string& name : names) {
    for (const TelemetryTopic& topic : telemetry_topics()) {
      if (topic.name == name && !is_chosen(name)) chosen.push_back(topic);
    }
  }
  if (!names.empty()) return chosen;
  for (const TelemetryTopic& topic : telemetry_topics()) {
    if (topic.is_usual) chosen.push_back(topic);
  }
  return chosen;
}

std::string json_line(const TelemetrySample& sample, const std::vector<TelemetryTopic>& topics) {
  ordered_json line;
  line["time_s"] = sample.time_s;
  line["unix_s"] = sample.unix_s;
  line["vehicle"] = sample.answer.value("vehicle", json());
  for (const TelemetryTopic& topic : topics) {
    ordered_json values;
    for (const std::string& key : topic.keys) {
      values[key] = value_of(sample.answer, topic.name, key);
    }
    values["age_s"] = value_of(sample.answer, topic.name, "age_s");
    line[topic.name] = std::move(values);
  }
  return line.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

std::string csv_header(const std::vector<TelemetryTopic>& topics) {
  std::string header = "time_s,unix_s,vehicle";
  for (const TelemetryTopic& topic : topics) {
    for (const std::string& key : topic.keys) header += "," + topic.name + "_" + key;
    header += "," + topic.name + "_age_s";
  }
  return header;
}

std::string csv_line(const TelemetrySample& sample, const std::vector<TelemetryTopic>& topics) {
  std::string line = fixed(sample.time_s, 3) + "," + fixed(sample.unix_s, 3) + "," +
                     csv_cell(sample.answer.value("vehicle", json()));
  for (const TelemetryTopic& topic : topics) {
    for (const std::string& key : topic.keys) {
      line += "," + csv_cell(value_of(sample.answer, topic.name, key));
    }
    line += "," + csv_cell(value_of(sample.answer, topic.name, "age_s"));
  }
  return line;
}

std::string text_lines(const TelemetrySample& sample, const std::vector<TelemetryTopic>& topics) {
  constexpr std::size_t kTimeWidth = 8;
  constexpr std::size_t kNameWidth = 10;
  const auto padding = [](const std::string& text, std::size_t width) {
    return std::string(width > text.size() ? width - text.size() : 0, ' ');
  };
  const std::string time = fixed(sample.time_s, 2);
  std::string lines;
  for (const TelemetryTopic& topic : topics) {
    lines += (lines.empty() ? "" : "\n") + padding(time, kTimeWidth) + time + " s  " + topic.name +
             padding(topic.name, kNameWidth) + values_text(sample.answer, topic);
  }
  return lines;
}

}  // namespace cas::casctl
