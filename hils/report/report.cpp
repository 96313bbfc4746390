// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/report.hpp"

#include <fmt/format.h>

#include "hils/report/paper_figures.hpp"

namespace cas::hils {

namespace {

std::string upper(std::string_view word) {
  std::string result(word);
  for (char& c : result) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return result;
}

std::string verdict_text(const Measurement& figures, const Verdict& verdict) {
  std::string text = fmt::format("{}: {}, {}, seed {}\n", verdict_word(verdict), figures.scenario,
                                 upper(to_string(figures.architecture)), figures.seed);
  for (const std::string& sentence : verdict.failures) text += "  - " + sentence + "\n";
  text += figures.virtual_clock
              ? fmt::format("  {:.1f} s simulated in {:.2f} s: {:.0f} x real time\n",
                            figures.simulated_s, figures.wall_s, figures.pace.real_time_factor)
              : fmt::format("  real-time factor {:.4f}, longest stall {:.1f} ms\n",
                            figures.pace.real_time_factor, figures.pace.worst_stall_ms);
  return text;
}

std::string rate_row(std::string_view name, double sensor_hz, double sensor_pct, double gps_hz,
                     double gps_pct, double controls_hz, double controls_pct) {
  return fmt::format("{:<16} {:>10.4f} {:>9.4f} {:>9.4f} {:>9.4f} {:>11.4f} {:>9.4f}\n", name,
                     sensor_hz, sensor_pct, gps_hz, gps_pct, controls_hz, controls_pct);
}

std::string rate_table(const Measurement& figures) {
  const StreamFigures& rates = figures.rates;
  std::string text =
      fmt::format("\nTable 4. Rates at the receiver over {:.1f} s{}\n",
                  static_cast<double>(figures.window.end_usec - figures.window.begin_usec) * 1e-6,
                  figures.over_hold ? " of hover" : " (no hover was reached)");
  text += fmt::format("{:<16} {:>20} {:>19} {:>21}\n", "",
                      fmt::format("IMU {:g} Hz", rates.sensor.nominal_hz),
                      fmt::format("GPS {:g} Hz", rates.gps.nominal_hz),
                      fmt::format("Control {:g} Hz", rates.controls.nominal_hz));
  text += fmt::format("{:<16} {:>10} {:>9} {:>9} {:>9} {:>11} {:>9}\n", "Name", "Hz", "error %",
                      "Hz", "error %", "Hz", "error %");
  text += rate_row(upper(to_string(figures.architecture)), rates.sensor.received_hz,
                   rates.sensor.error_pct, rates.gps.received_hz, rates.gps.error_pct,
                   rates.controls.received_hz, rates.controls.error_pct);
  for (const PaperRates& row : kPaperTable4) {
    text += rate_row(fmt::format("[HILS] {}", row.name), row.sensor_hz, row.sensor_error_pct,
                     row.gps_hz, row.gps_error_pct, row.controls_hz, row.controls_error_pct);
  }
  text += fmt::format("{:<16} {:>20} {:>19} {:>21}\n", "sent / lost",
                      fmt::format("{} / {}", rates.sensor.sent, rates.sensor.lost),
                      fmt::format("{} / {}", rates.gps.sent, rates.gps.lost),
                      fmt::format("{} / {}", rates.controls.sent, rates.controls.lost));
  return text;
}

std::string rms_row(std::string_view name, const RmsFigures& rms) {
  return fmt::format("{:<16} {:>8.4f} {:>8.4f} {:>8.4f} {:>10.4f}\n", name, rms.x_m, rms.y_m,
                     rms.z_m, rms.yaw_rad);
}

std::string rms_table(const Measurement& figures) {
  if (!figures.rms) return {};
  std::string text = "\nTable 5. RMS error of the hover\n";
  text += fmt::format("{:<16} {:>8} {:>8} {:>8} {:>10}\n", "Name", "X m", "Y m", "Z m", "Yaw rad");
  const std::string name = upper(to_string(figures.architecture));
  text += rms_row(name + " true", *figures.rms);
  if (figures.rms_estimate) text += rms_row(name + " estimate", *figures.rms_estimate);
  for (const PaperRms& row : kPaperTable5) {
    text += rms_row(fmt::format("[HILS] {}", row.name),
                    {.x_m = row.x_m, .y_m = row.y_m, .z_m = row.z_m, .yaw_rad = row.yaw_rad});
  }
  return text;
}

std::string delay_row(std::string_view name, const DelayFigures& delay) {
  return fmt::format("{:<34} {:>9.0f} {:>9.0f} {:>9.0f}\n", name, delay.p50, delay.p99, delay.max);
}

std::string delay_table(const Measurement& figures) {
  std::string text =
      fmt::format("\n{:<34} {:>9} {:>9} {:>9}\n", "Delay, us", "median", "99 %", "longest");
  text += delay_row("HIL_SENSOR out -> control back", figures.sensor_to_control);
  text += delay_row("HIL_SENSOR to the controller", figures.sensor_uplink);
  text += delay_row("control to the simulator", figures.controls_downlink);
  text += delay_row("age of the sample at use (made)", figures.age_by_stamp);
  text += delay_row("age of the sample at use (arrived)", figures.age_by_arrival);
  return text;
}

std::string loss_lines(const Measurement& figures) {
  std::string text;
  for (const PathAccount& path : figures.paths) {
    for (const auto& [cause, count] : path.losses) {
      text += fmt::format("{} {} lost {}\n", count, path.message, cause);
    }
  }
  if (figures.from_device) {
    text += fmt::format(
        "The controller keeps no ledger: packets are followed from the simulator to casd's port "
        "and "
        "back.\nBeyond it only gaps in its sequence numbers tell of losses: {} packets.\n",
        figures.lost_by_sequence);
  }
  return text.empty() ? text : "\n" + text;
}

std::string response_table(const Measurement& figures) {
  if (figures.responses.empty()) return {};
  std::string text = fmt::format("\n{:<16} {:>8} {:>8} {:>12} {:>12} {:>16}\n", "Step", "size m",
                                 "rise s", "overshoot %", "settling s", "int. error m s");
  for (const StepResponse& response : figures.responses) {
    const auto seconds = [](const std::optional<double>& value) {
      return value ? fmt::format("{:.2f}", *value) : std::string("-");
    };
    text += fmt::format("{:<16} {:>8.2f} {:>8} {:>12.1f} {:>12} {:>16.3f}\n", response.name,
                        response.size, seconds(response.rise_s), response.overshoot_pct,
                        seconds(response.settling_s), response.integrated_error);
  }
  return text;
}

std::string figures_text(const Measurement& figures) {
  return rate_table(figures) + rms_table(figures) + delay_table(figures) + loss_lines(figures) +
         response_table(figures);
}

/// What each vehicle did, in a line.
std::string overview_table(const RunResult& run) {
  std::string text = fmt::format("\n{:<24} {:>8} {:>20} {:>8} {:>8} {:>8}\n", "Vehicle", "verdict",
                                 "lost IMU/GPS/control", "RMS X m", "Y m", "Z m");
  for (const VehicleResult& vehicle : run.vehicles) {
    const StreamFigures& rates = vehicle.figures.rates;
    const std::optional<RmsFigures>& rms = vehicle.figures.rms;
    text += fmt::format(
        "{:<24} {:>8} {:>20} {:>8} {:>8} {:>8}\n", vehicle.figures.vehicle,
        verdict_word(vehicle.verdict),
        fmt::format("{} / {} / {}", rates.sensor.lost, rates.gps.lost, rates.controls.lost),
        rms_text(rms, &RmsFigures::x_m), rms_text(rms, &RmsFigures::y_m),
        rms_text(rms, &RmsFigures::z_m));
  }
  return text;
}

}  // namespace

std::string_view verdict_word(const Verdict& verdict) {
  if (!verdict.valid) return "INVALID";
  return verdict.passed ? "PASSED" : "FAILED";
}

std::string rms_text(const std::optional<RmsFigures>& rms, double RmsFigures::*axis) {
  return rms ? fmt::format("{:.4f}", (*rms).*axis) : "-";
}

std::string text_report(const Measurement& figures, const Verdict& verdict) {
  return verdict_text(figures, verdict) + figures_text(figures);
}

std::string text_report(const RunResult& run) {
  if (!run.has_several()) return text_report(run.vehicles.front().figures, run.verdict);
  std::string text = verdict_text(run.whole(), run.verdict) + overview_table(run);
  for (const VehicleResult& vehicle : run.vehicles) {
    text += fmt::format("\n== {} ==\n", vehicle.figures.vehicle) + figures_text(vehicle.figures);
  }
  return text;
}

}  // namespace cas::hils
