// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/figure_table.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>

#include "tests/hils/report/run_text.hpp"

namespace cas::hils {
namespace {

/// Each figure has another value.
Measurement filled() {
  double next = 1;
  const auto rate = [&next] {
    const auto count = [&next] { return static_cast<std::uint64_t>(++next); };
    return RateFigures{.nominal_hz = ++next,
                       .sent = 1000 * count(),
                       .received = 1000 + count(),
                       .lost = count(),
                       .received_hz = ++next + 0.5,
                       .error_pct = -++next};
  };
  const auto delay = [&next] {
    return DelayFigures{.count = static_cast<std::uint64_t>(++next),
                        .p50 = ++next,
                        .p90 = ++next,
                        .p99 = ++next,
                        .max = ++next};
  };
  const auto rms = [&next] {
    return RmsFigures{.x_m = ++next, .y_m = ++next, .z_m = ++next, .yaw_rad = ++next, .samples = 1};
  };
  Measurement m;
  m.rates = {rate(), rate(), rate()};
  m.meter = {.sensor_hz = ++next, .gps_hz = ++next, .controls_hz = ++next};
  for (DelayFigures* figures : {&m.sensor_to_control, &m.sensor_uplink, &m.controls_downlink,
                                &m.age_by_stamp, &m.age_by_arrival}) {
    *figures = delay();
  }
  m.rms = rms();
  m.rms_estimate = rms();
  m.peak_error_m = ++next;
  m.height_error_m = ++next;
  m.drift_m = ++next;
  m.rotor_activity_rad_s2 = ++next;
  m.radius_error_pct = ++next;
  m.least_airspeed_m_s = ++next;
  m.transition_height_m = ++next;
  m.landing_error_m = ++next;
  m.beacon_error_m = ++next;
  m.sticks_way_m = ++next;
  m.clearance = TerrainClearance{.least_m = ++next, .most_m = ++next};
  m.pace = {.real_time_factor = ++next, .worst_stall_ms = ++next, .late_p99_ms = ++next};
  m.handover_p99_us = ++next;
  m.paused_ms = ++next;
  m.reading_spread_us = ++next;
  m.port_gap_ms = ++next;
  m.firmware.emplace().hops = fmt::format(R"([{{"routes": [{{"p99": {}}}]}}])", ++next);
  m.cpu_pressure = ++next;
  m.simulated_s = ++next;
  m.wall_s = 5000;
  m.cpu_s = {{"hilsim", 7}, {"casd", 10}};  // 0.2 %
  return m;
}

template <class Of>
void expect_words(const std::vector<Figure<Of>>& table) {
  std::set<std::string> keys;
  std::set<std::string> places;
  std::set<std::string> titles;
  for (const Figure<Of>& row : table) {
    EXPECT_TRUE(keys.insert(row.key).second) << row.key << " is there twice";
    EXPECT_TRUE(places.insert(row.place()).second) << row.place() << " is there twice";
    EXPECT_TRUE(titles.insert(row.title).second) << row.title << " is there twice";
    EXPECT_FALSE(row.meaning.empty()) << row.key;
  }
}

TEST(FigureTable, GivesEachFigureAKeyAPlaceATitleAndAMeaning) {
  expect_words(figure_table());
  expect_words(response_table());
  EXPECT_EQ(figure_row("peak_error_m").title, "largest error of the true position");
  EXPECT_THROW(figure_row("no_such_figure"), std::logic_error);
}

/// The end of a key is its unit, as everywhere in the project.
TEST(FigureTable, NamesTheUnitInTheKey) {
  const std::map<std::string, std::string> units{
      {"_us", "us"},          {"_ms", "ms"},           {"_s", "s"},   {"_m", "m"},
      {"_rad", "rad"},        {"_hz", "Hz"},           {"_pct", "%"}, {"_m_s", "m s"},
      {"_rad_s2", "rad/s^2"}, {"_airspeed_m_s", "m/s"}};
  const auto expect_unit = [&units](const std::string& key, const std::string& unit) {
    std::string longest;  // "_m_s" before "_s"
    for (const auto& [end, of_key] : units) {
      if (key.ends_with(end) && end.size() > longest.size()) longest = end;
    }
    const bool names_none = unit.empty() || unit == "packets";
    EXPECT_EQ(longest.empty() ? "" : units.at(longest), names_none ? "" : unit) << key;
  };
  for (const auto& row : figure_table()) expect_unit(row.key, row.unit);
  for (const auto& row : response_table()) expect_unit(row.key, row.unit);
}

TEST(FigureTable, ReadsAnotherMemberInEachRow) {
  const Measurement figures = filled();
  std::map<double, std::string> keys;
  for (const auto& row : figure_table()) {
    const std::optional<double> value = row.get(figures);
    ASSERT_TRUE(value) << row.key;
    const auto [other, is_new] = keys.emplace(*value, row.key);
    EXPECT_TRUE(is_new) << row.key << " and " << other->second << " are both " << *value;
  }
}

TEST(FigureTable, ReadsTheFigureOfItsName) {
  const Measurement figures = filled();
  const auto value = [&figures](const char* key) { return figure_row(key).get(figures).value(); };
  EXPECT_EQ(value("gps_lost"), static_cast<double>(figures.rates.gps.lost));
  EXPECT_EQ(value("controls_rate_error_pct"), figures.rates.controls.error_pct);
  EXPECT_EQ(value("sensor_delivered_pct"), 100.0 *
                                               static_cast<double>(figures.rates.sensor.received) /
                                               static_cast<double>(figures.rates.sensor.sent));
  EXPECT_EQ(value("gps_meter_hz"), figures.meter.gps_hz);
  EXPECT_EQ(value("sensor_to_control_p99_us"), figures.sensor_to_control.p99);
  EXPECT_EQ(value("age_by_arrival_max_us"), figures.age_by_arrival.max);
  EXPECT_EQ(value("rms_estimate_yaw_rad"), figures.rms_estimate->yaw_rad);
  EXPECT_EQ(value("rms_position_m"),
            std::hypot(figures.rms->x_m, figures.rms->y_m, figures.rms->z_m));
  EXPECT_EQ(value("peak_error_m"), *figures.peak_error_m);
  EXPECT_NEAR(value("casd_cpu_pct"), 0.2, 1e-12);
}

TEST(FigureTable, HasNoValueOfWhatWasNotMeasured) {
  const Measurement nothing;
  for (const char* key : {"handover_p99_us", "reading_spread_us", "cpu_pressure", "casd_cpu_pct",
                          "sensor_delivered_pct", "sensor_to_control_count", "sensor_uplink_p50_us",
                          "rms_x_m", "rms_estimate_z_m", "rms_position_m", "peak_error_m",
                          "height_error_m", "drift_m", "rotor_activity_rad_s2"}) {
    EXPECT_FALSE(figure_row(key).get(nothing)) << key;
  }
}

TEST(FigureTable, IsWhatASummaryHasAtEachPlace) {
  const Measurement figures = filled();
  const auto run = test::run_summary(figures, Verdict{});
  for (const auto& row : figure_table()) {
    const bool is_of_run = row.part == Figure<Measurement>::Part::kRun;
    const nlohmann::json& summary = is_of_run ? run : run.at("vehicles").at(0);
    std::string path = "/" + row.place();
    std::ranges::replace(path, '.', '/');
    const nlohmann::json::json_pointer place(path);
    ASSERT_TRUE(summary.contains(place)) << row.place();
    EXPECT_EQ(summary.at(place).get<double>(), row.get(figures)) << row.place();
    EXPECT_EQ(summary.at(place).is_number_integer(), row.is_count()) << row.place();
  }
}

TEST(FigureTable, LeavesABlockWithoutAValueNullInASummary) {
  EXPECT_TRUE(test::run_summary(Measurement{}, Verdict{}).at("cpu_pressure").is_null());
  const auto summary = test::vehicle_summary(Measurement{}, Verdict{});
  for (const char* block : {"/latency_us/sensor_uplink", "/age_at_use_us/by_stamp", "/rms",
                            "/rms_estimate", "/peak_error_m"}) {
    const nlohmann::json::json_pointer place(block);
    ASSERT_TRUE(summary.contains(place)) << block;
    EXPECT_TRUE(summary.at(place).is_null()) << block;
  }
  EXPECT_EQ(summary.at("rates").at("HIL_GPS").at("lost"), 0);
  EXPECT_TRUE(summary.at("rates").at("HIL_GPS").at("delivered_pct").is_null());
}

TEST(FigureTable, IsPrintedWithADirectionForEachFigureThatHasOne) {
  const std::string text = figure_reference();
  EXPECT_NE(text.find("\n| `age_by_stamp_p50_us`, `age_by_stamp_p90_us`, `age_by_stamp_p99_us`, "
                      "`age_by_stamp_max_us` | age of the sample at use (made) | us | down | of "),
            text.npos)
      << text;
  EXPECT_NE(text.find("\n| `KEY_delivered_pct` | MESSAGE delivered | % | up | received, of those "
                      "sent | `rates.MESSAGE.delivered_pct` |\n"),
            text.npos)
      << text;
  EXPECT_NE(
      text.find("\n| `rms_x_m`, `rms_y_m`, `rms_z_m` | RMS error of the true position | m | "),
      text.npos)
      << text;
  EXPECT_NE(text.find("\n| `real_time_factor` | real-time factor |  | up | "), text.npos) << text;
  EXPECT_NE(text.find("\n| `settling_s` | settling time | s | down | "), text.npos) << text;
  EXPECT_NE(text.find("\n| `wall_s` | elapsed time | s |  | "), text.npos) << text;
}

}  // namespace
}  // namespace cas::hils
