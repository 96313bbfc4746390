// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/text_report.hpp"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <span>

#include "hils/report/change_table.hpp"
#include "hils/report/delay_note.hpp"
#include "hils/report/experiment.hpp"
#include "hils/report/figure_rows.hpp"
#include "hils/report/number_text.hpp"
#include "hils/report/plugin_section.hpp"

namespace cas::hils {
namespace {

std::string verdict_text(const Measurement& figures, const Verdict& verdict) {
  std::string text = fmt::format("{}: {}, {}, seed {}\n", verdict.word(), figures.scenario,
                                 how_it_ran(figures), figures.seed);
  for (const std::string& sentence : verdict.failures) text += "  - " + sentence + "\n";
  for (const std::string& remark : verdict.remarks) text += "  note: " + remark + "\n";
  for (const std::string& warning : verdict.warnings) text += "  warning: " + warning + "\n";
  if (const auto unjudged = unjudged_failure(figures, verdict)) text += "  " + *unjudged + "\n";
  text += figures.virtual_clock
              ? fmt::format("  {:.1f} s simulated in {:.2f} s: {:.{}f} x real time\n",
                            figures.simulated_s, figures.wall_s, figures.pace.real_time_factor,
                            figures.pace.real_time_factor < 10 ? 2 : 0)
              : fmt::format(
                    "  real-time factor {:.4f}, longest stall {:.1f} ms, 99 % less than {:.1f} ms "
                    "late\n",
                    figures.pace.real_time_factor, figures.pace.worst_stall_ms,
                    figures.pace.late_p99_ms);
  return text;
}

/// A table of fixed widths: the first column left-aligned, the others right-aligned.
std::string lines(const Rows& rows, std::span<const int> widths) {
  std::string text;
  for (const std::vector<std::string>& row : rows) {
    text += fmt::format("{:<{}}", row.front(), widths.front());
    for (std::size_t i = 1; i < row.size(); ++i) {
      text += fmt::format(" {:>{}}", row[i], widths[i]);
    }
    text += "\n";
  }
  return text;
}

/// Faults of the flight; first, because they explain the figures below.
std::string fault_table(const Measurement& figures) {
  const Rows rows = fault_rows(figures);
  if (rows.empty()) return {};
  constexpr std::array kColumns{34, 9, 9};
  return "\n" + lines({{"Fault", "begin s", "end s"}}, kColumns) + lines(rows, kColumns);
}

std::string rate_table(const Measurement& figures) {
  constexpr std::array kColumns{16, 10, 9, 9, 9, 11, 9};
  constexpr std::array kPairs{16, 20, 19, 21};
  const StreamFigures& rates = figures.rates;
  const auto over = [](const char* name, const RateFigures& rate) {
    return fmt::format("{} {:g} Hz", name, rate.nominal_hz);
  };
  const auto losses = [](const RateFigures& rate) {
    return fmt::format("{} / {}", rate.sent, rate.lost);
  };
  return fmt::format(
             "\nTable 4. Rates at the receiver over {:.1f} s of {}\n",
             static_cast<double>(figures.window.end_usec - figures.window.begin_usec) * 1e-6,
             figures.over_hold ? measured_part(figures)
                               : "flight (the measured step was not completed)") +
         lines({{"", over("IMU", rates.sensor), over("GPS", rates.gps),
                 over("Control", rates.controls)}},
               kPairs) +
         lines({{"Name", "Hz", "error %", "Hz", "error %", "Hz", "error %"}}, kColumns) +
         lines(rate_rows(figures), kColumns) +
         lines({{"sent / lost", losses(rates.sensor), losses(rates.gps), losses(rates.controls)}},
               kPairs);
}

std::string rms_table(const Measurement& figures) {
  if (!figures.rms) return {};
  constexpr std::array kColumns{16, 8, 8, 8, 10};
  const std::string name = title_of(figures.architecture);
  return fmt::format("\n{}RMS error of the {}\n",
                     measures_station_keeping(figures) ? "Table 5. " : "", measured_part(figures)) +
         lines({{"Name", "X m", "Y m", "Z m", "Yaw rad"}}, kColumns) +
         lines(rms_rows(figures, {name + " true", name + " estimate"}), kColumns);
}

std::string delay_table(const Measurement& figures) {
  if (figures.lockstep) {
    return "\nNo delays: in lockstep the line is left out, and packets take no simulated time.\n";
  }
  std::string text = "\n" + lines(delay_rows(figures), std::array{34, 9, 9, 9, 9});
  if (has_negative_delay(figures)) text += fmt::format("{}\n", kNegativeDelayNote);
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
        "and back.\nBeyond it only gaps in its sequence numbers tell of losses: {} packets.\n",
        figures.lost_by_sequence);
  }
  return text.empty() ? text : "\n" + text;
}

std::string response_table(const Measurement& figures) {
  if (figures.responses.empty()) return {};
  return "\n" + lines(response_rows(figures), std::array{16, 8, 13, 13, 17, 21});
}

/// Figures of the plugins: the value, or the range of a series.
std::string plugin_table(const Measurement& figures) {
  if (figures.plugins.empty()) return {};
  Rows rows{{"Plugin", "reports"}};
  for (const PluginFigure& figure : figures.plugins) {
    rows.push_back({figure.plugin + ": " + figure.name,
                    value_text(figure) + (figure.unit.empty() ? "" : " ") + figure.unit});
  }
  return "\n" + lines(rows, std::array{48, 0});
}

std::string figures_text(const Measurement& figures) {
  return fault_table(figures) + changes_text(figures.changes) + rate_table(figures) +
         response_table(figures) + rms_table(figures) + delay_table(figures) + loss_lines(figures) +
         plugin_table(figures);
}

/// One line for each vehicle.
std::string overview_table(const RunResult& run) {
  Rows rows{{"Vehicle", "verdict", "lost IMU", "GPS", "control", "RMS X m", "Y m", "Z m"}};
  for (const VehicleResult& vehicle : run.vehicles) {
    std::vector<std::string> row =
        figure_cells(vehicle.figures, vehicle.figures.vehicle,
                     {"sensor_lost", "gps_lost", "controls_lost", "rms_x_m", "rms_y_m", "rms_z_m"});
    row.insert(row.begin() + 1, std::string(vehicle.verdict.word()));
    rows.push_back(std::move(row));
  }
  return "\n" + lines(rows, std::array{24, 8, 8, 6, 8, 8, 8, 8});
}

}  // namespace

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
