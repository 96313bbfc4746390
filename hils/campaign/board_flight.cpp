// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/board_flight.hpp"

#include <fmt/format.h>

#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "hils/bench/fly.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/boards/flight_boards.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/measure/run_result.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/replay/replay_command.hpp"
#include "hils/report/results_folder.hpp"
#include "hils/sweep/flight_digest.hpp"
#include "hils/sweep/row_flight.hpp"
#include "hils/sweep/sweep_runner.hpp"
#include "hils/ulog/run_ulog.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

/// Writes the files that hils run writes. A flight without a replay keeps its verdict.
void write_artefacts(const RunRequest& request, const RunResult& run) {
  write_results(request, run);
  write_ulog(request, run.vehicles.front().record, 0);
  try {
    write_replay(request, run);
  } catch (const std::exception& error) {
    fmt::print(stderr, "the replay was not written: {}\n", error.what());
  }
}

/// Makes the folder of a row's flight, which stays, and writes its scenario there.
fs::path write_row_scenario(const RowTask& task) {
  const fs::path campaign = task.scenario.parent_path();
  const fs::path folder = campaign / "again" / fmt::format("row_{}", task.row);
  base::make_result_folder({campaign, folder});
  write_scenario(task.scenario, task.values, task.study_folder, folder);
  return folder;
}

/// @param fetch_logs  set where there may be logs: for after the result has been written
RowResult fly_on_board(const RowTask& task, std::function<void()>& fetch_logs) {
  const CampaignControllers controllers = CampaignControllers::load(task.scenario.parent_path());
  RunRequest request;
  request.out = write_row_scenario(task);
  request.scenario = Scenario::load(request.out / "scenario.yaml");
  request.architecture = task.architecture;
  request.seed = task.seed;
  const bool begun_before = fs::exists(request.out / "run");
  clear_earlier_run(request.out);

  const auto own = std::make_shared<const FlightBoards>(
      parse_fcu_words(controllers.words, request.scenario.names()), controllers.boards,
      "a flight of hils campaign", std::nullopt);
  const FlightBoards& boards = *own;
  if (const auto missing = boards.missing_port()) throw BoardError(kExitBoardAbsent, *missing);
  // A flight of this row that was interrupted may have left the board armed.
  if (task.row > 1 || begun_before) {
    boards.restart(request.out, controllers.baud);
  }
  request.fcu_devices = boards.prepare(request.out, request.scenario.names(), controllers.baud);
  RunResult run = evaluate(request, fly(request));
  std::map<std::size_t, std::string> gone = boards.absences();
  if (auto missing = boards.missing_port()) gone[0] = std::move(*missing);
  fail_absent(gone, run);
  write_artefacts(request, run);
  if (!gone.empty()) return row_without_figures(RowOutcome::kDied, gone.begin()->second);
  fetch_logs = [own, out = request.out, names = request.scenario.names()] {
    own->fetch_logs(out, names);
  };
  RowResult result = row_of(request.scenario, run);
  if (result.outcome == RowOutcome::kInvalid && result.strike) {
    result.strike->no_verdict = "the flight has no verdict: " + result.cause;
  }
  return result;
}

/// Stock firmware in software flies no two flights alike, so each keeps its report and replay. What
/// the firmware itself wrote goes: a log of its own is ten times as large.
RowResult fly_on_firmware(const RowTask& task, const fs::path&) {
  RunRequest request;
  request.out = write_row_scenario(task);
  request.scenario = Scenario::load(request.out / "scenario.yaml");
  request.architecture = request.scenario.architecture;
  request.seed = task.seed;
  request.clock = fastest_clock(request.scenario);
  clear_earlier_run(request.out);
  const RunResult run = evaluate(request, fly(request));
  write_artefacts(request, run);
  base::remove_result_folder({request.out, "run/firmware"});
  RowResult result = row_of(request.scenario, run);
  result.truth_sha256 = truth_sha256(run);
  return result;
}

}  // namespace

void CampaignControllers::save(const fs::path& folder) const {
  OrderedJson json{{"fcu", words}, {"boards", boards.empty() ? "" : fs::absolute(boards).string()}};
  if (baud) json["baud"] = *baud;
  base::write_result({folder, kControllersFile}, json.dump(2) + "\n");
}

CampaignControllers CampaignControllers::load(const fs::path& folder) {
  const fs::path file = folder / kControllersFile;
  try {
    const OrderedJson json = OrderedJson::parse(text_of_file(file));
    CampaignControllers controllers{.words = json.at("fcu").get<std::vector<std::string>>(),
                                    .boards = json.at("boards").get<std::string>(),
                                    .baud = {}};
    if (json.contains("baud")) controllers.baud = json["baud"].get<unsigned>();
    return controllers;
  } catch (const OrderedJson::exception&) {
    throw base::ConfigError(file.string() + ": is not JSON as hils writes it");
  }
}

int fly_campaign_row(const fs::path& folder) {
  const fs::path scenario = RowTask::load(folder / "task.json").scenario;
  if (!fs::exists(scenario.parent_path() / kControllersFile)) {
    return fly_row(folder, fly_on_firmware);
  }
  try {
    std::function<void()> fetch_logs;
    const int code = fly_row(folder, [&fetch_logs](const RowTask& task, const fs::path&) {
      try {
        return fly_on_board(task, fetch_logs);
      } catch (const RunStopped& stopped) {
        if (stopped.interrupted()) throw;
        // A program ended, or the controller was not ready: another try may go well.
        return row_without_figures(RowOutcome::kDied, stopped.what());
      }
    });
    if (code == kExitPassed && fetch_logs) fetch_logs();
    return code;
  } catch (const BoardError& error) {
    base::write_result({folder, kBoardSentence}, error.what());
    return error.code();
  }
}

}  // namespace cas::hils
