// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/timing_report.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "hils/report/aligned_table.hpp"
#include "hils/report/number_text.hpp"

namespace cas::hils {

namespace {

using Json = nlohmann::json;
using Rows = std::vector<std::vector<std::string>>;

std::string kilobytes(double bytes_s) { return fixed(bytes_s / 1e3, 1); }

std::string lost_words(const EchoFigures& echoes) {
  return fmt::format("{} of {}", echoes.lost(), echoes.asked);
}

std::string echo_table(const LineFigures& figures) {
  Rows rows{{"ROUND TRIP, MS", "LEAST", "MEDIAN", "P99", "LONGEST", "JITTER", "LOST"}};
  const auto add = [&rows](std::string_view name, const EchoFigures& echoes) {
    rows.push_back({std::string(name), fixed(echoes.least_ms, 2), fixed(echoes.median_ms, 2),
                    fixed(echoes.p99_ms, 2), fixed(echoes.longest_ms, 2),
                    fixed(echoes.jitter_ms, 2), lost_words(echoes)});
  };
  add(to_string(QuestionKind::kPing), figures.ping);
  add(to_string(QuestionKind::kTimesync), figures.timesync);
  return aligned_table(rows, Cells::kRight);
}

std::string load_table(const LineFigures& figures) {
  Rows rows{{"LOAD, HIL_SENSOR HZ", "TO, KB/S", "FROM, KB/S", "MEDIAN, MS", "P99", "LONGEST", "GAP",
             "BYTES A READ", "LOST", ""}};
  const auto add = [&rows](const LoadFigures& load) {
    rows.push_back({fmt::format("{:g}", load.sensor_hz), kilobytes(load.to_bytes_s),
                    kilobytes(load.from_bytes_s), fixed(load.echoes.median_ms, 2),
                    fixed(load.echoes.p99_ms, 2), fixed(load.echoes.longest_ms, 2),
                    fixed(load.longest_gap_ms, 1), fixed(load.bytes_per_read, 0),
                    lost_words(load.echoes), load.kept() ? "kept" : "TOO MUCH"});
  };
  for (const LoadFigures& load : figures.loads) add(load);
  for (const LoadFigures& load : figures.slower) add(load);
  return aligned_table(rows, Cells::kRight);
}

std::string frame_words(const std::optional<base::Duration>& frame) {
  if (!frame) return "answers come in no frames that can be seen";
  return fmt::format("answers come in frames of {:g} ms", 1e3 * base::to_seconds(*frame));
}

Json echo_json(const EchoFigures& echoes) {
  return {{"asked", echoes.asked},        {"lost", echoes.lost()},
          {"least_ms", echoes.least_ms},  {"median_ms", echoes.median_ms},
          {"p99_ms", echoes.p99_ms},      {"longest_ms", echoes.longest_ms},
          {"jitter_ms", echoes.jitter_ms}};
}

Json load_json(const LoadFigures& load) {
  return {{"sensor_hz", load.sensor_hz},
          {"round_trip", echo_json(load.echoes)},
          {"to_bytes_s", load.to_bytes_s},
          {"from_bytes_s", load.from_bytes_s},
          {"longest_gap_ms", load.longest_gap_ms},
          {"bytes_per_read", load.bytes_per_read},
          {"own_lateness_ms", load.own_lateness_ms},
          {"kept", load.kept()}};
}

Json loads_json(const std::vector<LoadFigures>& loads) {
  Json all = Json::array();
  for (const LoadFigures& load : loads) all.push_back(load_json(load));
  return all;
}

Json verdict_json(const TimingVerdict& verdict) {
  Json json{{"fits", verdict.code == kExitPassed}, {"exit_code", static_cast<int>(verdict.code)},
            {"sentence", verdict.sentence},        {"spare", verdict.spare},
            {"fitting_sensor_hz", nullptr},        {"notes", verdict.notes}};
  if (verdict.fitting_sensor_hz) json["fitting_sensor_hz"] = *verdict.fitting_sensor_hz;
  return json;
}

}  // namespace

std::string timing_text(const TimingReport& report) {
  const LineFigures& figures = report.figures;
  std::string text = fmt::format(
      "{} at {} baud: system {}, disarmed, {}; it sends {} kB/s by itself\n\n{}\n{}\n"
      "throughput: {} kB/s to it, {} kB/s from it\n\n{}\n",
      report.device, report.baud, figures.autopilot.system,
      figures.in_hil ? "in HIL" : "not in HIL", kilobytes(figures.background_bytes_s),
      echo_table(figures), frame_words(figures.frame), kilobytes(figures.to_bytes_s),
      kilobytes(figures.from_bytes_s), load_table(figures));
  for (const std::string& note : report.verdict.notes) text += "note: " + note + "\n";
  return text + report.verdict.sentence + "\n";
}

std::string timing_json(const TimingReport& report) {
  const LineFigures& figures = report.figures;
  Json json{{"device", report.device},
            {"baud", report.baud},
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
