// SPDX-License-Identifier: BSD-3-Clause
#include "hils/compare/compare_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/config/install_paths.hpp"
#include "base/os/write_file.hpp"
#include "base/time/clock.hpp"
#include "hils/compare/comparison.hpp"
#include "hils/compare/comparison_report.hpp"
#include "hils/report/report.hpp"

namespace cas::hils {

namespace {

ComparisonPlan make_plan(const CompareFlags& flags) {
  ComparisonPlan plan;
  plan.scenario = Scenario::load(base::find_config(flags.scenario));
  std::vector<Architecture> architectures;
  for (const std::string& word : flags.architectures) {
    architectures.push_back(parse_architecture(word));
  }
  plan.variants = make_variants(architectures, flags.bauds);
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

bool any_valid(const VariantResult& result) {
  return std::ranges::any_of(result.verdicts, [](const Verdict& verdict) { return verdict.valid; });
}

}  // namespace

int compare(const CompareFlags& flags) {
  const ComparisonPlan plan = make_plan(flags);
  const std::filesystem::path out = std::filesystem::absolute(flags.out);
  std::filesystem::create_directories(out / "plots");
  const base::RunTime begin = base::steady_now();
  const std::vector<VariantResult> results = run_comparison(plan, out, flags.keep);
  const double wall_s = base::to_seconds(base::steady_now() - begin);

  const std::string tables = comparison_markdown(plan, results);
  base::write_file(out / "comparison.md", tables, base::Durability::kCache);
  base::write_file(out / "comparison.json", comparison_json(plan, results),
                   base::Durability::kCache);
  base::write_file(out / "comparison.html", comparison_html(plan, results),
                   base::Durability::kCache);
  for (const auto& [name, plot] : comparison_plots(results)) {
    base::write_file(out / "plots" / (name + ".svg"), to_svg(plot), base::Durability::kCache);
  }
  double simulated_s = 0;
  for (const VariantResult& result : results) {
    for (const Measurement& figures : result.runs) simulated_s += figures.simulated_s;
  }
  fmt::print("{}\n{:.0f} s simulated in {:.1f} s\nResults: {}\n", tables, simulated_s, wall_s,
             flags.out);
  return std::ranges::all_of(results, any_valid) ? kExitPassed : kExitInvalid;
}

}  // namespace cas::hils
