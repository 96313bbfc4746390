// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/cli/whole_number.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "base/time/clock.hpp"
#include "hils/compare/comparison.hpp"
#include "hils/compare/comparison_report.hpp"
#include "hils/report/results_folder.hpp"
#include "hils/run/verbs.hpp"

namespace cas::hils {

namespace {

struct Flags {
  std::vector<std::string> scenarios;
  std::vector<std::string> architectures{"direct", "sitl", "ts", "loop", "tcas"};
  std::vector<unsigned> bauds{460800, 921600};
  std::size_t seeds = 5;
  std::uint64_t first_seed = 1;
  double warm_up_s = 10;
  double hold_s = 60;
  bool on_virtual_clock = false;
  bool keep = false;
  bool markdown = false;
  std::string out;
};

ComparisonPlan make_plan(const Flags& flags) {
  ComparisonPlan plan;
  for (const std::string& file : flags.scenarios) {
    plan.scenarios.push_back(Scenario::load(base::find_config(file)));
  }
  if (plan.has_several()) {
    plan.variants = make_variants(plan.scenarios);
  } else {
    std::vector<Architecture> architectures;
    for (const std::string& word : flags.architectures) {
      architectures.push_back(parse_architecture(word));
    }
    if (plan.scenarios.front().firmware) {
      throw base::ConfigError(flags.scenarios.front() +
                              ": stock firmware is connected in one way; compare it with another "
                              "scenario: hils compare A.yaml B.yaml");
    }
    plan.variants = make_variants(architectures, flags.bauds);
  }
  for (std::uint64_t i = 0; i < flags.seeds; ++i) plan.seeds.push_back(flags.first_seed + i);
  plan.warm_up_s = flags.warm_up_s;
  plan.hold_s = flags.hold_s;
  plan.virtual_clock = flags.on_virtual_clock;
  if (plan.seeds.empty() || plan.variants.empty() || !(plan.hold_s > 0) || !(plan.warm_up_s > 0)) {
    throw base::ConfigError(
        "a comparison needs at least one seed and one architecture, and times above 0");
  }
  return plan;
}

int compare(const Flags& flags) {
  const ComparisonPlan plan = make_plan(flags);
  const std::filesystem::path out = std::filesystem::absolute(flags.out);
  make_results_folder(out);
  const base::RunTime begin = base::steady_now();
  const std::vector<VariantResult> results = run_comparison(plan, out, flags.keep);
  const double wall_s = base::to_seconds(base::steady_now() - begin);

  const Document report = comparison_report(plan, results);
  base::write_result({out, "comparison.md"}, write_markdown(report));
  base::write_result({out, "comparison.json"}, comparison_json(plan, results));
  base::write_result({out, "comparison.html"}, write_html(report));
  for (const auto& [name, plot] : comparison_plots(results)) {
    base::write_result({out, std::filesystem::path("plots") / (name + ".svg")}, to_svg(plot));
  }
  double simulated_s = 0;
  for (const VariantResult& result : results) {
    for (const Measurement& figures : result.runs) simulated_s += figures.simulated_s;
  }
  const bool markdown = flags.markdown || ::isatty(STDOUT_FILENO) == 0;
  fmt::print("{}\n{:.0f} s simulated in {:.1f} s\nResults: {}\n",
             markdown ? write_markdown(report) : write_text(report), simulated_s, wall_s,
             flags.out);
  return exit_code(results);
}

}  // namespace

base::cli::Verb add_compare(CLI::App& app) {
  const auto kept = std::make_shared<Flags>();
  Flags& flags = *kept;
  CLI::App* command = app.add_subcommand(
      "compare",
      "Fly one scenario in several architectures, as [HILS] Sect. 4 does, or several scenarios");
  command
      ->add_option("SCENARIO", flags.scenarios,
                   "Scenario file; of several each is flown as it is: one vehicle with our "
                   "controller, PX4 and ArduPilot")
      ->required();
  command
      ->add_option("--architectures", flags.architectures,
                   "Of one scenario: some of direct,sitl,ts,loop,tcas")
      ->delimiter(',');
  command->add_option("--baud", flags.bauds, "Of the line where there is one: 460800,921600")
      ->delimiter(',')
      ->check(CLI::IsMember({115200, 460800, 921600}));
  command->add_option("--seeds", flags.seeds, "Runs of each (5)")->check(base::cli::whole_number);
  command
      ->add_option("--first-seed", flags.first_seed,
                   "Seed of the first run; the others follow it (1)")
      ->check(base::cli::whole_number);
  command->add_option("--warm-up", flags.warm_up_s,
                      "Of one scenario: seconds of hover before the measurement (10)");
  command->add_option("--hold", flags.hold_s, "Of one scenario: seconds measured (60)");
  command->add_flag("--virtual", flags.on_virtual_clock,
                    "Compute time instead of waiting for it: the same to the byte each time");
  command->add_flag("--markdown", flags.markdown,
                    "Print Markdown on a terminal, too, as comparison.md has it");
  command->add_flag("--keep", flags.keep, "Keep truth.csv, sensors and flight.tlog of each run");
  command->add_option("--out", flags.out, "Folder for the results (the last, if several)")
      ->required()
      ->take_last();
  return {command, [kept] { return compare(*kept); }};
}

}  // namespace cas::hils
