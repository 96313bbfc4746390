// SPDX-License-Identifier: BSD-3-Clause
#include "hils/compare/comparison_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <nlohmann/json.hpp>

#include "hils/compare/comparison_table.hpp"
#include "hils/measure/figure_table.hpp"
#include "hils/report/experiment.hpp"
#include "hils/report/flight_warnings.hpp"

namespace cas::hils {

namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr int kSchema = 2;

/// Columns become rows: a page is less wide than it is long.
Rows transposed(const Rows& rows) {
  Rows result(rows.front().size());
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) result[i].push_back(row[i]);
  }
  return result;
}

OrderedJson mean_json(const std::optional<Mean>& mean) {
  if (!mean) return nullptr;
  return {{"mean", mean->mean}, {"half_width_95", mean->half_width}, {"runs", mean->count}};
}

/// By the keys of the figures. @param mean_of  takes a FigureColumn
template <class MeanOf>
OrderedJson figures_json(const MeanOf& mean_of) {
  OrderedJson figures = OrderedJson::object();
  for (const Figure<Measurement>& row : figure_table()) figures[row.key] = mean_json(mean_of(&row));
  return figures;
}

FlightWarnings warnings_of(const VariantResult& result) {
  FlightWarnings warnings;
  for (const Verdict& verdict : result.verdicts) warnings.add(verdict.warnings);
  return warnings;
}

OrderedJson variant_json(const VariantResult& result) {
  OrderedJson json{{"name", result.variant.name()},
                   {"architecture", to_string(result.variant.architecture)},
                   {"baud", result.variant.baud},
                   {"validity", validity_words(result)}};
  json["figures"] =
      figures_json([&](FigureColumn column) { return mean_of_valid(result, column); });
  json["sent"] = sent_of(result);
  json["losses"] = losses_of(result);
  OrderedJson runs = OrderedJson::array();
  for (std::size_t i = 0; i < result.runs.size(); ++i) {
    runs.push_back({{"seed", result.runs[i].seed},
                    {"valid", result.verdicts[i].valid},
                    {"failures", result.verdicts[i].failures}});
  }
  json["runs"] = std::move(runs);
  json["warnings"] = warnings_json<OrderedJson>(warnings_of(result));
  return json;
}

}  // namespace

std::string comparison_headline(const ComparisonPlan& plan) {
  if (plan.has_several()) {
    return fmt::format(
        "{} scenarios as they are; {} seeds ({} to {}), interleaved; {}; stock "
        "firmware in its own time",
        plan.scenarios.size(), plan.seeds.size(), plan.seeds.front(), plan.seeds.back(),
        plan.virtual_clock ? "virtual clock" : "real time");
  }
  return fmt::format(
      "{}: {} seeds ({} to {}), interleaved; {:g} s warm-up, then {:g} s measured; {}; cross "
      "traffic: telemetry, a ground station that loads the parameters every 20 s",
      plan.scenarios.front().name, plan.seeds.size(), plan.seeds.front(), plan.seeds.back(),
      plan.warm_up_s, plan.hold_s, plan.virtual_clock ? "virtual clock" : "real time");
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

std::string comparison_json(const ComparisonPlan& plan, const std::vector<VariantResult>& results) {
  OrderedJson json{{"schema", kSchema},
                   {"scenario", plan.scenarios.front().name},
                   {"virtual_clock", plan.virtual_clock},
                   {"warm_up_s", plan.warm_up_s},
                   {"hold_s", plan.hold_s},
                   {"seeds", plan.seeds}};
  json["variants"] = OrderedJson::array();
  for (const VariantResult& result : results) json["variants"].push_back(variant_json(result));
  json["differences"] = OrderedJson::array();
  for (const auto& [a, b] : comparison_pairs(results)) {
    OrderedJson pair{{"of", results[a].variant.name()}, {"less", results[b].variant.name()}};
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

namespace {

/// Mean over the valid runs.
std::optional<Mean> mean_of_runs(
    const VariantResult& result,
    const std::function<std::optional<double>(const Measurement&)>& value_of) {
  std::vector<double> values;
  for (std::size_t i = 0; i < result.runs.size(); ++i) {
    const auto value = result.verdicts[i].valid ? value_of(result.runs[i]) : std::nullopt;
    if (value) values.push_back(*value);
  }
  return values.empty() ? std::nullopt : std::optional(mean_of(values));
}

/// How each took the first fault of its scenario.
void add_strikes(const std::vector<VariantResult>& results, Document& page) {
  struct Column {
    const char* title;
    std::optional<double> (*get)(const StrikeResponse&);
  };
  static constexpr std::array<Column, 4> kColumns{
      {{"noticed after s", [](const StrikeResponse& s) { return s.detected_s; }},
       {"reacted after s", [](const StrikeResponse& s) { return s.reacted_s; }},
       {"farthest m", [](const StrikeResponse& s) { return std::optional(s.farthest_m); }},
       {"largest tilt deg",
        [](const StrikeResponse& s) { return std::optional(s.peak_tilt_deg); }}}};
  Rows rows{{"", "fault"}};
  for (const Column& column : kColumns) rows.front().push_back(column.title);
  for (const VariantResult& result : results) {
    const auto struck = std::ranges::find_if(
        result.runs, [](const Measurement& run) { return run.strike.has_value(); });
    if (struck == result.runs.end()) continue;
    Row row{result.variant.name(), struck->strike->fault};
    for (const Column& column : kColumns) {
      row.push_back(to_text(mean_of_runs(result,
                                         [&column](const Measurement& run) {
                                           return run.strike ? column.get(*run.strike)
                                                             : std::nullopt;
                                         }),
                            2));
    }
    rows.push_back(std::move(row));
  }
  if (rows.size() > 1) page.table("Reaction to the first fault", std::move(rows));
}

/// How each followed the steps of its reference.
void add_responses(const std::vector<VariantResult>& results, Document& page) {
  Rows rows{{"", "step"}};
  for (const Figure<StepResponse>& row : response_table()) {
    rows.front().push_back(fmt::format("{}, {}", row.title, row.unit));
  }
  for (const VariantResult& result : results) {
    if (result.runs.empty()) continue;
    for (const StepResponse& first : result.runs.front().responses) {
      Row row{result.variant.name(), first.name};
      for (const Figure<StepResponse>& figure : response_table()) {
        const auto value_of = [&](const Measurement& run) -> std::optional<double> {
          const auto found = std::ranges::find(run.responses, first.name, &StepResponse::name);
          return found == run.responses.end() ? std::nullopt : figure.get(*found);
        };
        row.push_back(to_text(mean_of_runs(result, value_of), figure.digits));
      }
      rows.push_back(std::move(row));
    }
  }
  if (rows.size() > 1) page.table("Responses to steps of the reference", std::move(rows));
}

/// What differs from controller to controller: reactions and pace.
void add_behaviour(const std::vector<VariantResult>& results, Document& page) {
  add_responses(results, page);
  add_strikes(results, page);
  Rows rows{{"", "controller", "pace"}};
  for (const VariantResult& result : results) {
    if (result.runs.empty()) continue;
    rows.push_back({result.variant.name(), how_it_ran(result.runs.front()),
                    to_text(mean_of_runs(result,
                                         [](const Measurement& run) {
                                           return std::optional(run.pace.real_time_factor);
                                         }),
                            2)});
  }
  page.table("Who flew", std::move(rows), {}, Align::kLeft);
}

}  // namespace

Document comparison_report(const ComparisonPlan& plan, const std::vector<VariantResult>& results) {
  std::string names;
  for (const Scenario& scenario : plan.scenarios) {
    names += (names.empty() ? "" : ", ") + scenario.name;
  }
  Document page{"Comparison: " + names};
  std::vector<std::string> remarks;
  bool all_valid = true;
  for (const VariantResult& result : results) {
    remarks.push_back(result.variant.name() + ": " + validity_words(result));
    for (const std::string& sentence : warnings_of(result).sentences()) {
      remarks.push_back(result.variant.name() + ": " + sentence);
    }
    for (const Verdict& verdict : result.verdicts) all_valid = all_valid && verdict.valid;
  }
  page.add(Document::Verdict{all_valid ? Mood::kGood : Mood::kNeutral,
                             all_valid ? "All runs valid" : "Not all runs valid",
                             comparison_headline(plan), std::move(remarks)});
  for (const ColumnGroup& group : comparison_groups()) {
    if (!has_figures(group, results)) continue;
    Rows rows = group_rows(group, results);
    std::vector<Look> looks(results.size(), Look::kPlain);
    looks.resize(rows.size() - 1, Look::kQuiet);
    page.table(group.title, std::move(rows), std::move(looks));
  }
  if (plan.has_several()) add_behaviour(results, page);
  page.table("Lost packets, by cause, of all valid runs", loss_rows(results));
  const Rows pairs = difference_rows(results);
  if (pairs.size() > 1) {
    page.table("Paired differences by seed: mean and 95 % interval", transposed(pairs));
  }
  page.heading("First seed", Extent::kPage);
  for (auto& [name, plot] : comparison_plots(results)) page.add(std::move(plot));
  return page;
}

}  // namespace cas::hils
