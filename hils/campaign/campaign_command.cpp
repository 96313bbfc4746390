// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/cli/whole_number.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/boards/board_flags.hpp"
#include "hils/boards/flight_boards.hpp"
#include "hils/campaign/board_flight.hpp"
#include "hils/campaign/campaign.hpp"
#include "hils/campaign/campaign_report.hpp"
#include "hils/campaign/catalogue.hpp"
#include "hils/campaign/matrix.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/report/junit_report.hpp"
#include "hils/report/results_folder.hpp"
#include "hils/run/verbs.hpp"
#include "hils/sweep/row_again.hpp"
#include "hils/sweep/sweep_folder.hpp"
#include "hils/sweep/sweep_runner.hpp"

namespace cas::hils {

namespace fs = std::filesystem;

namespace {

struct Flags {
  std::string file;
  std::string out;
  std::optional<std::size_t> jobs;
  std::vector<std::string> fcus;  ///< as parse_fcu_words() takes them
  std::optional<unsigned> fcu_baud;
  BoardFlags boards;
  std::vector<std::string> only;
  std::string task;  ///< folder of a flight that this process is for
  bool list = false;
  bool markdown = false;
  bool plan = false;
  std::size_t replays = 200;
  bool retry = false;
};

/// A start with boards that were not there has left its plan, and nothing that was flown.
bool was_never_flown(const fs::path& out) {
  if (!fs::exists(out / kControllersFile)) return false;
  std::error_code none;
  for (fs::directory_iterator entry(out / "journal", none), end; !none && entry != end;
       entry.increment(none)) {
    if (entry->file_size(none) > 0) return false;
  }
  return !none || none == std::errc::no_such_file_or_directory;
}

/// The sweep's folder of a campaign: planned, or as it was planned before.
/// @param controllers  noted first, so that the plan is not flown without them; nullptr: none
SweepFolder plan_of(const Campaign& campaign, const fs::path& out,
                    const CampaignControllers* controllers) {
  const fs::path study = out / "campaign" / "study.yaml";
  const std::string text = study_of(campaign);
  if (was_never_flown(out)) {
    fs::remove(out / "plan.json");
    fs::remove(out / kControllersFile);
  }
  if (fs::exists(out / "plan.json") && text_of_file(out / "study.yaml") != text) {
    throw base::ConfigError(out.string() +
                            ": holds another campaign, or this one before its failures, phases or "
                            "seeds were changed; its flights stay as they are: choose another "
                            "folder");
  }
  make_results_folder(out);
  if (controllers != nullptr) controllers->save(out);
  base::write_result({out, study}, text, base::Durability::kDisk);
  return SweepFolder::plan(study, out, campaign.folder);
}

/// The same, and says how much that is.
SweepFolder announced_plan_of(const Campaign& campaign, const fs::path& out,
                              const CampaignControllers* controllers = nullptr) {
  SweepFolder sweep = plan_of(campaign, out, controllers);
  fmt::print("{}: {} failures, {} flights ({} of them without a failure) in {}\n", campaign.name,
             campaign.failures.size(), sweep.table.rows.size(), campaign.seeds.size(),
             (sweep.path / "table.csv").string());
  return sweep;
}

/// Rows of the flights that the cells lead to, those of cells that are not as expected first.
std::vector<std::size_t> shown_rows(const CampaignMatrix& matrix, std::size_t most) {
  std::vector<std::size_t> rows;
  for (const bool good : {false, true}) {
    for (const CellResult& cell : matrix.cells) {
      if ((cell.state() == CellState::kAsExpected) != good || !cell.shown().response) continue;
      if (rows.size() < most) rows.push_back(cell.shown().row);
    }
  }
  return rows;
}

/// @return the report
Document write_results(const CampaignMatrix& matrix, const SweepFolder& sweep) {
  Document report = campaign_report(matrix, sweep.path / "again");
  base::write_result({sweep.path, "results.json"}, campaign_json(matrix), base::Durability::kDisk);
  base::write_result({sweep.path, "results.csv"}, campaign_csv(matrix), base::Durability::kDisk);
  base::write_result({sweep.path, "junit.xml"}, campaign_junit(matrix), base::Durability::kDisk);
  base::write_result({sweep.path, "campaign.md"}, write_markdown(report), base::Durability::kDisk);
  base::write_result({sweep.path, "campaign.html"}, write_html(report), base::Durability::kDisk);
  return report;
}

/// @throws base::ConfigError
void refuse_flags_of_the_virtual_clock(bool plan, const std::optional<std::size_t>& jobs) {
  if (plan) {
    throw base::ConfigError("--plan: a campaign with boards is flown by 'hils campaign' itself");
  }
  if (jobs.value_or(1) > 1) {
    throw base::ConfigError("--jobs: with boards there is one flight at a time");
  }
}

struct BoardCampaignOptions {
  std::string file;  ///< the campaign's, as its user names it
  fs::path out;
  std::optional<base::Duration> wait;
  bool retry = false;
};

/// Takes the boards. @throws BoardError with a report, base::ConfigError
void hold_boards(const Campaign& campaign, const CampaignControllers& controllers,
                 const BoardCampaignOptions& options, std::optional<FlightBoards>& held) {
  try {
    held.emplace(parse_fcu_words(controllers.words, Scenario::load(campaign.scenario).names()),
                 controllers.boards, "hils campaign " + options.file, options.wait);
  } catch (const BoardError& error) {
    fs::create_directories(options.out);
    base::write_result(
        {options.out, "junit.xml"},
        junit_report("hils.campaign." + campaign.name, 0, Verdict{.failures = {error.what()}}),
        base::Durability::kDisk);
    throw;
  }
}

/// Holds the boards until the last flight has ended. If one of them stops the campaign, the flights
/// so far are reported. @throws BoardError, RunStopped, base::ConfigError
int fly_on_boards(const Campaign& campaign, const CampaignControllers& controllers,
                  const BoardCampaignOptions& options) {
  std::optional<FlightBoards> held;
  hold_boards(campaign, controllers, options, held);
  const SweepFolder sweep = announced_plan_of(campaign, options.out, &controllers);
  const auto report = [&](const std::string& stopped) {
    CampaignMatrix matrix =
        CampaignMatrix::of(campaign, sweep.results(1, sweep.table.rows.size() + 1));
    matrix.stopped = stopped;
    const Document own = write_results(matrix, sweep);
    fmt::print("{}\nResults: {}\n", write_text(own), sweep.path.string());
    return matrix.exit_code();
  };
  try {
    run_sweep(sweep, {.verb = "campaign",
                      .jobs = 1,
                      .retry = options.retry,
                      .after_s = base::to_seconds(held->log_time()),
                      .on_boards = true});
  } catch (const BoardError& error) {
    report(error.what());
    throw;
  }
  return report({});
}

int run(const Flags& flags) {
  if (flags.list) {
    const FailureCatalogue catalogue = flags.file.empty()
                                           ? FailureCatalogue::shipped()
                                           : catalogue_of(base::find_config(flags.file));
    fmt::print("{}", flags.markdown ? catalogue.markdown() : catalogue.text());
    return kExitPassed;
  }
  if (!flags.task.empty()) return fly_campaign_row(flags.task);
  if (flags.file.empty() || flags.out.empty()) {
    throw base::ConfigError("campaign takes CAMPAIGN.yaml and --out DIR, or --list");
  }
  const fs::path out = fs::absolute(flags.out);
  const Campaign campaign = Campaign::load(base::find_config(flags.file),
                                           {.controllers = flags.fcus, .only = flags.only});
  if (campaign.is_on_boards()) {
    refuse_flags_of_the_virtual_clock(flags.plan, flags.jobs);
    return fly_on_boards(
        campaign, {.words = flags.fcus, .boards = flags.boards.file(), .baud = flags.fcu_baud},
        {.file = flags.file, .out = out, .wait = flags.boards.patience(), .retry = flags.retry});
  }
  if (flags.fcu_baud || flags.boards.are_given()) {
    throw base::ConfigError("--fcu-baud, --boards and --wait belong to --fcu");
  }
  const SweepFolder sweep = announced_plan_of(campaign, out);
  if (flags.plan) return kExitPassed;
  const std::size_t jobs = flags.jobs.value_or(usual_jobs(sweep));
  run_sweep(sweep, {.verb = "campaign",
                    .jobs = jobs,
                    .retry = flags.retry,
                    .keeps_flights = campaign.on_firmware});
  const std::vector<RowResult> results = sweep.results(1, sweep.table.rows.size() + 1);
  CampaignMatrix matrix = CampaignMatrix::of(campaign, results);
  write_results(matrix, sweep);
  for (const std::size_t row : fly_again(sweep, shown_rows(matrix, flags.replays), jobs)) {
    if (flew_otherwise(sweep, results[row - 1])) matrix.flown_otherwise.insert(row);
  }
  const Document report = write_results(matrix, sweep);  // with links to the replays
  fmt::print("{}\nResults: {}\n", write_text(report), flags.out);
  return matrix.exit_code();
}

}  // namespace

base::cli::Verb add_campaign(CLI::App& app) {
  const auto kept = std::make_shared<Flags>();
  Flags& flags = *kept;
  CLI::App* campaign =
      app.add_subcommand("campaign", "Let failures strike in a flight and check what must happen");
  campaign->add_option("CAMPAIGN", flags.file, "Campaign file (docs/use/campaign.md)");
  campaign->add_option("--out", flags.out, "Folder for the results (the last, if several)")
      ->take_last();
  campaign
      ->add_option("--jobs", flags.jobs,
                   "Flights at once (as many as processors; of stock firmware 1)")
      ->check(base::cli::whole_number)
      ->check(CLI::Range(1, 4096));
  campaign->add_option("--only", flags.only, "Fly these failures of the campaign alone: NAME,NAME")
      ->delimiter(',')
      ->allow_extra_args(false);
  campaign
      ->add_option("--fcu", flags.fcus,
                   "Fly in real time, one flight after the other, with a board of boards.yaml or "
                   "the controller at the path of a serial port, which is held to the end")
      ->allow_extra_args(false);
  campaign->add_option("--fcu-baud", flags.fcu_baud,
                       "Baud rate of that port (the board's, or 921600)");
  add_board_flags(*campaign, flags.boards);
  campaign->add_option("--fly", flags.task)->group("");  // of the runner, for its processes
  campaign->add_flag("--plan", flags.plan,
                     "Write the table of flights and fly nothing: 'hils sweep run' flies it");
  campaign
      ->add_option("--replays", flags.replays,
                   "Most cells that get a report and a replay of one flight; those that are not as "
                   "expected come first (200)")
      ->check(base::cli::whole_number);
  campaign->add_flag("--retry", flags.retry, "Fly what died or hung once more");
  campaign->add_flag(
      "--list", flags.list,
      "Print the failures that may strike, with those of CAMPAIGN's own file, and end");
  campaign->add_flag("--markdown", flags.markdown, "With --list: as a table in Markdown");
  return {campaign, [kept] { return run(*kept); }};
}

}  // namespace cas::hils
