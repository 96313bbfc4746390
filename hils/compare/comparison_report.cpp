// SPDX-License-Identifier: BSD-3-Clause
#include "hils/compare/comparison_report.hpp"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "hils/compare/comparison_table.hpp"
#include "hils/report/aligned_table.hpp"
#include "hils/report/html_page.hpp"

namespace cas::hils {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kSchema = 2;

std::string markdown_table(const Rows& rows) {
  std::string text;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    text += "|";
    for (const std::string& cell : rows[r]) text += " " + cell + " |";
    text += "\n";
    if (r > 0) continue;
    text += "|";
    for (std::size_t i = 0; i < rows[r].size(); ++i) text += i == 0 ? "---|" : "---:|";
    text += "\n";
  }
  return text;
}

std::string table_text(const Rows& rows, TableStyle style) {
  return style == TableStyle::kMarkdown ? markdown_table(rows) : aligned_table(rows, Cells::kRight);
}

/// Columns become rows: a page is less wide than it is long.
Rows transposed(const Rows& rows) {
  Rows result(rows.front().size());
  for (const std::vector<std::string>& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) result[i].push_back(row[i]);
  }
  return result;
}

Json mean_json(const std::optional<Mean>& mean) {
  if (!mean) return nullptr;
  return {{"mean", mean->mean}, {"half_width_95", mean->half_width}, {"runs", mean->count}};
}

/// By the keys of the figures. @param mean_of  takes a FigureColumn
template <class MeanOf>
Json figures_json(const MeanOf& mean_of) {
  Json figures = Json::object();
  for (const Figure<Measurement>& row : figure_table()) figures[row.key] = mean_json(mean_of(&row));
  return figures;
}

Json variant_json(const VariantResult& result) {
  Json json{{"name", result.variant.name()},
            {"architecture", to_string(result.variant.architecture)},
            {"baud", result.variant.baud},
            {"validity", validity_words(result)}};
  json["figures"] =
      figures_json([&](FigureColumn column) { return mean_of_valid(result, column); });
  json["sent"] = sent_of(result);
  json["losses"] = losses_of(result);
  Json runs = Json::array();
  for (std::size_t i = 0; i < result.runs.size(); ++i) {
    runs.push_back({{"seed", result.runs[i].seed},
                    {"valid", result.verdicts[i].valid},
                    {"failures", result.verdicts[i].failures}});
  }
  json["runs"] = std::move(runs);
  return json;
}

}  // namespace

std::string comparison_headline(const ComparisonPlan& plan) {
  return fmt::format(
      "{}: {} seeds ({} to {}), interleaved; {:g} s warm-up, then {:g} s measured; {}; cross "
      "traffic: telemetry, a ground station that loads the parameters every 20 s",
      plan.scenario.name, plan.seeds.size(), plan.seeds.front(), plan.seeds.back(), plan.warm_up_s,
      plan.hold_s, plan.virtual_clock ? "virtual clock" : "real time");
}

std::string validity_words(const VariantResult& result) {
  std::size_t valid = 0;
  std::size_t flown = 0;
  std::string reason;
  for (std::size_t i = 0; i < result.runs.size(); ++i) {
    valid += result.verdicts[i].valid ? 1 : 0;
    flown += result.runs[i].flight_failure ? 0 : 1;
    if (reason.empty() && !result.verdicts[i].failures.empty()) {
      reason = result.verdicts[i].failures.front();
    }
  }
  return fmt::format("{} of {} runs valid, {} flown to the end{}{}", valid, result.runs.size(),
                     flown, reason.empty() ? "" : "; first remark: ", reason);
}

std::string comparison_text(const ComparisonPlan& plan, const std::vector<VariantResult>& results,
                            TableStyle style) {
  std::string text = comparison_headline(plan) + "\n\n";
  for (const VariantResult& result : results) {
    text += fmt::format("- {}: {}\n", result.variant.name(), validity_words(result));
  }
  for (const ColumnGroup& group : comparison_groups()) {
    if (!has_figures(group, results)) continue;
    text += fmt::format("\n{}\n\n{}", group.title, table_text(group_rows(group, results), style));
  }
  text += "\nLost packets, by cause, of all valid runs\n\n" + table_text(loss_rows(results), style);
  const Rows pairs = difference_rows(results);
  if (pairs.size() > 1) {
    text += "\nPaired differences by seed: mean and 95 % interval\n\n" + table_text(pairs, style);
  }
  return text;
}

std::string comparison_json(const ComparisonPlan& plan, const std::vector<VariantResult>& results) {
  Json json{{"schema", kSchema},
            {"scenario", plan.scenario.name},
            {"virtual_clock", plan.virtual_clock},
            {"warm_up_s", plan.warm_up_s},
            {"hold_s", plan.hold_s},
            {"seeds", plan.seeds}};
  json["variants"] = Json::array();
  for (const VariantResult& result : results) json["variants"].push_back(variant_json(result));
  json["differences"] = Json::array();
  for (const auto& [a, b] : comparison_pairs(results)) {
    Json pair{{"of", results[a].variant.name()}, {"less", results[b].variant.name()}};
    pair["figures"] = figures_json(
        [&](FigureColumn column) { return difference_of(results[a], results[b], column); });
    json["differences"].push_back(std::move(pair));
  }
  return json.dump(2) + "\n";
}

std::vector<std::pair<std::string, Plot>> comparison_plots(
    const std::vector<VariantResult>& results) {
  struct Picture {
    const char* name;
    const char* title;
    const char* unit;
    Series RunCurves::*curve;
    Series RunCurves::*reference;
  };
  constexpr std::array<Picture, 7> kPictures{
      {{"fig16_imu", "Fig. 16 HIL_SENSOR received, share of nominal", "%", &RunCurves::sensor_rate,
        nullptr},
       {"fig16_gps", "Fig. 16 HIL_GPS received, share of nominal", "%", &RunCurves::gps_rate,
        nullptr},
       {"fig16_controls", "Fig. 16 Controls received, share of nominal", "%",
        &RunCurves::controls_rate, nullptr},
       {"fig17_x", "Fig. 17 North", "m", &RunCurves::x, &RunCurves::x_reference},
       {"fig17_y", "Fig. 17 East", "m", &RunCurves::y, &RunCurves::y_reference},
       {"fig17_z", "Fig. 17 Height", "m", &RunCurves::z, &RunCurves::z_reference},
       {"fig17_yaw", "Fig. 17 Heading", "rad", &RunCurves::yaw, nullptr}}};
  std::vector<std::pair<std::string, Plot>> plots;
  for (const Picture& picture : kPictures) {
    Plot plot{.title = picture.title, .x_label = "simulated time, s", .y_label = picture.unit};
    for (const VariantResult& result : results) {
      plot.series.push_back(result.curves.*picture.curve);
    }
    if (picture.reference != nullptr && !results.empty()) {
      plot.series.push_back(results.front().curves.*picture.reference);
    }
    plots.emplace_back(picture.name, std::move(plot));
  }
  return plots;
}

std::string comparison_html(const ComparisonPlan& plan, const std::vector<VariantResult>& results) {
  HtmlPage page("Comparison: " + plan.scenario.name);
  std::vector<std::string> remarks;
  bool all_valid = true;
  for (const VariantResult& result : results) {
    remarks.push_back(result.variant.name() + ": " + validity_words(result));
    for (const Verdict& verdict : result.verdicts) all_valid = all_valid && verdict.valid;
  }
  page.verdict(all_valid ? HtmlPage::Mood::kGood : HtmlPage::Mood::kNeutral,
               all_valid ? "All runs valid" : "Not all runs valid", comparison_headline(plan),
               remarks);
  for (const ColumnGroup& group : comparison_groups()) {
    if (!has_figures(group, results)) continue;
    const Rows rows = group_rows(group, results);
    std::vector<HtmlPage::Row> looks(results.size(), HtmlPage::Row::kPlain);
    looks.resize(rows.size() - 1, HtmlPage::Row::kQuiet);
    page.table(group.title, rows, looks);
  }
  page.table("Lost packets, by cause, of all valid runs", loss_rows(results));
  const Rows pairs = difference_rows(results);
  if (pairs.size() > 1) {
    page.table("Paired differences by seed: mean and 95 % interval", transposed(pairs));
  }
  page.heading("First seed");
  for (const auto& [name, plot] : comparison_plots(results)) page.plot(plot);
  return page.finish();
}

}  // namespace cas::hils
