// SPDX-License-Identifier: BSD-3-Clause
// Flies the controller with the real simulator on the virtual clock and prints its figures beside
// the bounds they are held to.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "base/cli/parse.hpp"
#include "base/cli/whole_number.hpp"
#include "base/error.hpp"
#include "base/os/log.hpp"
#include "hils/measure/judgement.hpp"
#include "tests/bench/figures/consistency_figures.hpp"
#include "tests/bench/figures/flight_figures.hpp"

namespace {

using namespace cas;
using namespace cas::hils;

using Experiment = std::function<std::vector<FlightFigure>(const FlightBatch&)>;

const std::vector<std::pair<std::string, Experiment>>& experiments() {
  static const std::vector<std::pair<std::string, Experiment>> all{
      {"table1", [](const auto& batch) { return hover_figures("table1", 1.3, 1.5, batch); }},
      {"rtk", rtk_hover_figures},
      {"steps", step_figures},
      {"eight", figure_eight_figures},
      {"wind", wind_figures},
      {"line", poor_line_figures},
      {"consistency", consistency_figures},
      {"many", crash_figures}};
  return all;
}

void print(const FlightFigure& figure) {
  const std::string bound = figure.bound ? fmt::format("{:.4g}", *figure.bound) : "";
  fmt::print("| {} | {:.4g} {} | {} | {}{} |\n", figure.name, figure.value, figure.unit, bound,
             figure.note, figure.missed() ? " **missed**" : "");
}

int run(const std::vector<std::string>& wanted, const FlightBatch& batch) {
  fmt::print("| figure | value | at most | |\n|---|---|---|---|\n");
  std::vector<FlightFigure> shown;
  for (const auto& [name, experiment] : experiments()) {
    const bool chosen = wanted.empty()
                            ? name != "many" && name != "consistency"
                            : std::find(wanted.begin(), wanted.end(), name) != wanted.end();
    if (!chosen) continue;
    for (const FlightFigure& figure : experiment(batch)) {
      print(figure);
      shown.push_back(figure);
    }
    std::fflush(stdout);
  }
  return exit_code(shown);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Flies many flights and prints the controller's figures beside their bounds.",
               "flight_figures");
  app.set_version_flag("--version", "flight_figures " + std::string(CAS_VERSION));
  std::vector<std::string> wanted;
  FlightBatch batch;
  batch.jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  std::vector<std::string> names;
  for (const auto& entry : experiments()) names.push_back(entry.first);
  app.add_option(
         "experiment", wanted,
         "Any of table1, rtk, steps, eight, wind, line, consistency, many; all but the last two")
      ->check(CLI::IsMember(names));
  app.add_option("--flights", batch.flights, "Flights of each")->check(CLI::Range(1, 1'000'000));
  app.add_option("--first-seed", batch.first_seed, "Seed of the first flight; then each the next")
      ->check(base::cli::whole_number);
  app.add_option("--jobs", batch.jobs, "Flights at a time")->check(CLI::Range(1, 256));
  if (const auto ended = base::cli::parse(app, argc, argv, kExitUsage)) return *ended;
  try {
    base::log::init("flight_figures", base::log::parse_level("error"));
    return run(wanted, batch);
  } catch (const base::ConfigError& error) {
    fmt::print(stderr, "flight_figures: {}\n", error.what());
    return kExitUsage;
  } catch (const std::exception& error) {
    fmt::print(stderr, "flight_figures: {}\n", error.what());
    return kExitInvalid;
  }
}
