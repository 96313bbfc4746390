// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/campaign_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "base/cli/whole_number.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/write_file.hpp"
#include "hils/campaign/campaign.hpp"
#include "hils/campaign/campaign_report.hpp"
#include "hils/campaign/catalogue.hpp"
#include "hils/campaign/matrix.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/report/results_folder.hpp"
#include "hils/report/report.hpp"
#include "hils/sweep/row_again.hpp"
#include "hils/sweep/sweep_folder.hpp"
#include "hils/sweep/sweep_runner.hpp"

namespace cas::hils {

namespace fs = std::filesystem;

struct CampaignCommand::Flags {
  CLI::App* campaign = nullptr;
  std::string file;
  std::string out;
  std::size_t jobs = std::max(1U, std::thread::hardware_concurrency());
  bool list = false;
  bool markdown = false;
  bool plan = false;
  std::size_t replays = 200;
  bool retry = false;
};

namespace {

/// The sweep's folder of a campaign: planned, or as it was planned before.
SweepFolder plan_of(const Campaign& campaign, const fs::path& out) {
  const fs::path study = out / "campaign" / "study.yaml";
  const std::string text = study_of(campaign);
  if (fs::exists(out / "plan.json") && text_of_file(out / "study.yaml") != text) {
    throw base::ConfigError(out.string() +
                            ": holds another campaign, or this one before its failures, phases or "
                            "seeds were changed; its flights stay as they are: choose another "
                            "folder");
  }
  make_results_folder(out);
  fs::create_directories(study.parent_path());
  base::write_file(study, text);
  return SweepFolder::plan(study, out, campaign.folder);
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

void write_results(const CampaignMatrix& matrix, const SweepFolder& sweep) {
  base::write_file(sweep.path / "results.json", campaign_json(matrix));
  base::write_file(sweep.path / "results.csv", campaign_csv(matrix));
  base::write_file(sweep.path / "junit.xml", campaign_junit(matrix));
  base::write_file(sweep.path / "campaign.html", campaign_html(matrix, sweep.path / "again"));
}

}  // namespace

CampaignCommand::CampaignCommand(CLI::App& app) : flags_(std::make_unique<Flags>()) {
  Flags& flags = *flags_;
  flags.campaign =
      app.add_subcommand("campaign", "Let failures strike in a flight and check what must happen");
  flags.campaign->add_option("CAMPAIGN", flags.file, "Campaign file (docs/campaign.md)");
  flags.campaign->add_option("--out", flags.out, "Folder for the results (the last, if several)")
      ->take_last();
  flags.campaign->add_option("--jobs", flags.jobs, "Flights at once (as many as processors)")
      ->check(base::cli::whole_number)
      ->check(CLI::Range(1, 4096));
  flags.campaign->add_flag("--plan", flags.plan,
                           "Write the table of flights and fly nothing: 'hils sweep run' flies it");
  flags.campaign
      ->add_option("--replays", flags.replays,
                   "Most cells that get a report and a replay of one flight; those that are not as "
                   "expected come first (200)")
      ->check(base::cli::whole_number);
  flags.campaign->add_flag("--retry", flags.retry, "Fly what died or hung once more");
  flags.campaign->add_flag("--list", flags.list, "Print the catalogue of failures, and end");
  flags.campaign->add_flag("--markdown", flags.markdown, "With --list: as a table in Markdown");
}

CampaignCommand::~CampaignCommand() = default;

bool CampaignCommand::parsed() const { return flags_->campaign->parsed(); }

int CampaignCommand::run() const {
  const Flags& flags = *flags_;
  if (flags.list) {
    fmt::print("{}", flags.markdown ? catalogue_markdown() : catalogue_text());
    return kExitPassed;
  }
  if (flags.file.empty() || flags.out.empty()) {
    throw base::ConfigError("campaign takes CAMPAIGN.yaml and --out DIR, or --list");
  }
  const fs::path out = fs::absolute(flags.out);
  const Campaign campaign = Campaign::load(base::find_config(flags.file));
  const SweepFolder sweep = plan_of(campaign, out);
  fmt::print("{}: {} failures, {} flights in {}\n", campaign.name, campaign.failures.size(),
             sweep.table.rows.size(), (sweep.path / "table.csv").string());
  if (flags.plan) return kExitPassed;
  run_sweep(sweep, {.jobs = flags.jobs, .retry = flags.retry});
  const std::vector<RowResult> results = sweep.results(1, sweep.table.rows.size() + 1);
  CampaignMatrix matrix = CampaignMatrix::of(campaign, results);
  write_results(matrix, sweep);
  for (const std::size_t row : fly_again(sweep, shown_rows(matrix, flags.replays), flags.jobs)) {
    if (flew_otherwise(sweep, results[row - 1])) matrix.flown_otherwise.insert(row);
  }
  write_results(matrix, sweep);  // with links to the replays
  fmt::print("{}\nResults: {}\n", campaign_text(matrix), flags.out);
  return matrix.exit_code();
}

}  // namespace cas::hils
