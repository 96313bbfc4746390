// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/row_flight.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/os/disk_error.hpp"
#include "base/os/result_file.hpp"
#include "hils/bench/fly.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/measure/run_result.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/sweep/flight_digest.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

/// Whether files can be written: if so, a failure is the run's own fault.
bool can_write(const fs::path& folder) {
  const fs::path probe = folder / "probe";
  try {
    base::write_result({folder, "probe"}, std::string(1U << 20U, '.'));
  } catch (const base::ConfigError&) {
    return false;
  }
  std::error_code ignored;
  fs::remove(probe, ignored);
  return true;
}

}  // namespace

RowResult fly_alone(const RowTask& task, const fs::path& folder) {
  write_scenario(task.scenario, task.values, task.study_folder, folder);
  RunRequest request;
  request.scenario = Scenario::load(folder / "scenario.yaml");
  if (figure_names(request.scenario) != task.figures) {
    throw base::ConfigError(
        "the run has other figures than the columns of its table: steps and vehicles have the same "
        "names in each run");
  }
  request.architecture =
      request.scenario.firmware ? request.scenario.architecture : task.architecture;
  request.seed = task.seed;
  request.keeps_sensors = false;  // no row needs them
  request.out = folder / "out";
  fs::create_directories(request.out);
  request.clock = fastest_clock(request.scenario);
  const RunResult run = evaluate(request, fly(request));
  RowResult result = row_of(request.scenario, run);
  result.truth_sha256 = truth_sha256(run);
  const bool varies_faults = std::ranges::any_of(
      task.values, [](const KeyValue& value) { return value.first == "faults"; });
  if (varies_faults) result.run_sha256 = run_sha256(run);
  return result;
}

RowTask RowTask::of(const SweepFolder& sweep, std::size_t row) {
  const TableRow& own = sweep.row(row);
  return {.row = row,
          .seed = own.seed,
          .architecture = sweep.study.architecture,
          .scenario = sweep.scenario(),
          .study_folder = sweep.study_folder,
          .values = sweep.values_of(own),
          .figures = sweep.figures};
}

void RowTask::save(const fs::path& file) const {
  OrderedJson json;
  json["row"] = row;
  json["seed"] = seed;
  json["architecture"] = to_string(architecture);
  json["scenario"] = scenario.string();
  json["study_folder"] = study_folder.string();
  json["values"] = values;
  json["figures"] = figures;
  base::write_result({file.parent_path(), file.filename()}, json.dump() + "\n");
}

RowTask RowTask::load(const fs::path& file) {
  try {
    const OrderedJson json = OrderedJson::parse(text_of_file(file));
    return {.row = json.at("row").get<std::size_t>(),
            .seed = json.at("seed").get<std::uint64_t>(),
            .architecture = parse_architecture(json.at("architecture").get<std::string>()),
            .scenario = json.at("scenario").get<std::string>(),
            .study_folder = json.at("study_folder").get<std::string>(),
            .values = json.at("values").get<std::vector<KeyValue>>(),
            .figures = json.at("figures").get<std::vector<std::string>>()};
  } catch (const OrderedJson::exception&) {
    throw base::ConfigError(file.string() + ": is not JSON as hils writes it");
  }
}

int fly_row(const fs::path& folder, const FlyTask& fly) {
  const RowTask task = RowTask::load(folder / "task.json");
  RowResult result;
  try {
    result = fly(task, folder);
  } catch (const RunStopped& stopped) {
    if (stopped.interrupted()) return kExitInterrupted;
    result = row_without_figures(RowOutcome::kStopped, without_folder(stopped.what(), folder));
  } catch (const base::DiskError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return kExitMachine;
  } catch (const base::ConfigError& error) {
    if (!can_write(folder)) {
      fmt::print(stderr, "{}\n", error.what());
      return kExitMachine;
    }
    result = row_without_figures(RowOutcome::kRefused, without_folder(error.what(), folder));
  } catch (const fs::filesystem_error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return kExitMachine;
  }
  result.row = task.row;
  result.version = CAS_VERSION;
  try {
    base::write_result({folder, "result.json"}, journal_line(result));
  } catch (const base::ConfigError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return kExitMachine;
  }
  return kExitPassed;
}

}  // namespace cas::hils
