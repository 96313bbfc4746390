// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/timing_report.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "hils/report/number_text.hpp"
#include "hils/report/verdict_section.hpp"

namespace cas::hils {

namespace {

std::string kilobytes(double bytes_s) { return fixed(bytes_s / 1e3, 1); }

std::string lost_words(const EchoFigures& echoes) {
  return fmt::format("{} of {}", echoes.lost(), echoes.asked);
}

Rows echo_rows(const LineFigures& figures) {
  Rows rows{{"of", "least", "median", "99 %", "longest", "jitter", "lost"}};
  const auto add = [&rows](std::string_view name, const EchoFigures& echoes) {
    rows.push_back({std::string(name), fixed(echoes.least_ms, 2), fixed(echoes.median_ms, 2),
                    fixed(echoes.p99_ms, 2), fixed(echoes.longest_ms, 2),
                    fixed(echoes.jitter_ms, 2), lost_words(echoes)});
  };
  add(to_string(QuestionKind::kPing), figures.ping);
  add(to_string(QuestionKind::kTimesync), figures.timesync);
  return rows;
}

Rows load_rows(const LineFigures& figures) {
  Rows rows{{"HIL_SENSOR Hz", "to kB/s", "from kB/s", "median ms", "99 %", "longest", "gap ms",
             "bytes a read", "lost", ""}};
  const auto add = [&rows](const LoadFigures& load) {
    rows.push_back({fmt::format("{:g}", load.sensor_hz), kilobytes(load.to_bytes_s),
                    kilobytes(load.from_bytes_s), fixed(load.echoes.median_ms, 2),
                    fixed(load.echoes.p99_ms, 2), fixed(load.echoes.longest_ms, 2),
                    fixed(load.longest_gap_ms, 1), fixed(load.bytes_per_read, 0),
                    lost_words(load.echoes), load.kept() ? "kept" : "TOO MUCH"});
  };
  for (const LoadFigures& load : figures.loads) add(load);
  for (const LoadFigures& load : figures.slower) add(load);
  return rows;
}

std::string frame_words(const std::optional<base::Duration>& frame) {
  if (!frame) return "answers come in no frames that can be seen";
  return fmt::format("answers come in frames of {:g} ms", 1e3 * base::to_seconds(*frame));
}

nlohmann::json echo_json(const EchoFigures& echoes) {
  return {{"asked", echoes.asked},        {"lost", echoes.lost()},
          {"least_ms", echoes.least_ms},  {"median_ms", echoes.median_ms},
          {"p99_ms", echoes.p99_ms},      {"longest_ms", echoes.longest_ms},
          {"jitter_ms", echoes.jitter_ms}};
}

nlohmann::json load_json(const LoadFigures& load) {
  return {{"sensor_hz", load.sensor_hz},
          {"round_trip", echo_json(load.echoes)},
          {"to_bytes_s", load.to_bytes_s},
          {"from_bytes_s", load.from_bytes_s},
          {"longest_gap_ms", load.longest_gap_ms},
          {"bytes_per_read", load.bytes_per_read},
          {"own_lateness_ms", load.own_lateness_ms},
          {"kept", load.kept()}};
}

nlohmann::json loads_json(const std::vector<LoadFigures>& loads) {
  nlohmann::json all = nlohmann::json::array();
  for (const LoadFigures& load : loads) all.push_back(load_json(load));
  return all;
}

nlohmann::json verdict_json(const TimingVerdict& verdict) {
  nlohmann::json json{
      {"fits", verdict.code == kExitPassed}, {"exit_code", static_cast<int>(verdict.code)},
      {"sentence", verdict.sentence},        {"spare", verdict.spare},
      {"fitting_sensor_hz", nullptr},        {"notes", verdict.notes}};
  if (verdict.fitting_sensor_hz) json["fitting_sensor_hz"] = *verdict.fitting_sensor_hz;
  return json;
}

}  // namespace

Document timing_report(const TimingReport& report) {
  const LineFigures& figures = report.figures;
  const TimingVerdict& verdict = report.verdict;
  Document page{"Timing of " + report.device};
  page.add(verdict_block({.valid = verdict.code != kExitInvalid,
                          .passed = verdict.code == kExitPassed,
                          .failures = {},
                          .checks = {},
                          .remarks = verdict.notes},
                         verdict.sentence));
  page.paragraph(
      fmt::format("{}, {}: system {}, disarmed, {}; it sends {} kB/s by itself; {}.", report.device,
                  report.is_pty ? "a pseudo-terminal" : fmt::format("{} baud", report.baud),
                  figures.autopilot.system, figures.in_hil ? "in HIL" : "not in HIL",
                  kilobytes(figures.background_bytes_s), frame_words(figures.frame)));
  page.table("Round trip, ms", echo_rows(figures));
  page.table(
      "Throughput, kB/s",
      {{"to it", "from it"}, {kilobytes(figures.to_bytes_s), kilobytes(figures.from_bytes_s)}});
  page.table("Under load", load_rows(figures));
  return page;
}

std::string timing_json(const TimingReport& report) {
  const LineFigures& figures = report.figures;
  nlohmann::json json{{"device", report.device},
                      {"baud", report.baud},
                      {"pseudo_terminal", report.is_pty},
                      {"system", figures.autopilot.system},
                      {"in_hil", figures.in_hil},
                      {"demand",
                       {{"sensor_hz", report.demand.sensor_hz},
                        {"gps_hz", report.demand.gps_hz},
                        {"controls_hz", report.demand.controls_hz}}},
                      {"background_bytes_s", figures.background_bytes_s},
                      {"ping", echo_json(figures.ping)},
                      {"timesync", echo_json(figures.timesync)},
                      {"frame_us", nullptr},
                      {"to_bytes_s", figures.to_bytes_s},
                      {"from_bytes_s", figures.from_bytes_s},
                      {"crc_errors", figures.crc_errors},
                      {"loads", loads_json(figures.loads)},
                      {"slower", loads_json(figures.slower)},
                      {"verdict", verdict_json(report.verdict)}};
  if (figures.frame) json["frame_us"] = 1e6 * base::to_seconds(*figures.frame);
  return json.dump(2) + "\n";
}

}  // namespace cas::hils
