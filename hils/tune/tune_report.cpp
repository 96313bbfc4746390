// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/tune_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include "hils/sweep/run_table.hpp"

namespace cas::hils {

namespace {

constexpr std::string_view kParams = "controller.params.";

/// Four digits, without a power of ten where it is some thousands.
std::string four_digits(double value) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  return size >= 1e4 && size < 1e7 ? fmt::format("{:.0f}", value) : fmt::format("{:.4g}", value);
}
/// For a table of numbers: empty where there is none.
std::string field(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

std::string change(double before, double after) {
  if (!std::isfinite(before) || !std::isfinite(after) || before == 0) return "-";
  return fmt::format("{:+.1f} %", (after - before) / std::abs(before) * 100);
}

Rows value_rows(const TuneStudy& study, const TuneResult& result) {
  Rows rows{{"Parameter", "before", "after", "least", "largest"}};
  const Candidate& after = result.candidates[result.best];
  for (std::size_t i = 0; i < study.vary.size(); ++i) {
    const Distribution& spread = *study.vary[i].parameter.distribution;
    rows.push_back({study.vary[i].parameter.name, result.candidates[0].values[i], after.values[i],
                    four_digits(*spread.least), four_digits(*spread.most)});
  }
  return rows;
}

Rows objective_rows(const TuneStudy& study, const TuneResult& result) {
  Rows rows{{"Objective or guard", "before", "after", "change", "bound"}};
  const Candidate& before = result.candidates[0];
  const Candidate& after = result.candidates[result.best];
  for (std::size_t i = 0; i < study.objectives.size(); ++i) {
    rows.push_back({study.objectives[i].figure.name, four_digits(before.objectives[i]),
                    four_digits(after.objectives[i]),
                    change(before.objectives[i], after.objectives[i]), ""});
  }
  for (std::size_t i = 0; i < study.guards.size(); ++i) {
    rows.push_back({study.guards[i].figure.name, four_digits(before.guards[i]),
                    four_digits(after.guards[i]), change(before.guards[i], after.guards[i]),
                    fmt::format("{} {}", study.guards[i].at_least ? ">=" : "<=",
                                four_digits(result.bounds[i]))});
  }
  rows.push_back({"weighted sum", four_digits(before.sum), four_digits(after.sum),
                  change(before.sum, after.sum), ""});
  return rows;
}

Rows verification_rows(const TuneResult& result) {
  Rows rows{{"Scenario", "figure", "before", "after", "change", "seeds better"}};
  for (const Verification& each : result.verification) {
    rows.push_back({each.scenario + (each.in_search ? "" : " (new)"), each.figure,
                    four_digits(each.before), four_digits(each.after),
                    change(each.before, each.after),
                    fmt::format("{} of {}", each.better, each.seeds)});
  }
  return rows;
}

/// Rows of figures that the search improved.
std::vector<Verification> verified_objectives(const TuneStudy& study, const TuneResult& result) {
  std::vector<Verification> rows;
  std::ranges::copy_if(result.verification, std::back_inserter(rows), [&](const auto& row) {
    return std::ranges::any_of(study.objectives, [&](const Objective& objective) {
      return objective.figure.name == row.figure;
    });
  });
  return rows;
}

const Objective& objective_of(const TuneStudy& study, const Verification& row) {
  return *std::ranges::find(study.objectives, row.figure,
                            [](const Objective& each) { return each.figure.name; });
}

/// Whether the verification shows what the search found: the weighted sum of the objectives is
/// smaller, and those with the greatest weight are better with most seeds.
/// @param rows  verified_objectives()
bool is_confirmed(const TuneStudy& study, const std::vector<Verification>& rows) {
  double heaviest = 0;
  for (const Objective& each : study.objectives) heaviest = std::max(heaviest, each.weight);
  double change = 0;
  for (const Verification& row : rows) {
    const double weight = objective_of(study, row).weight;
    if (weight == heaviest && 2 * row.better <= row.seeds) return false;
    change += weight * (row.before > 0 ? row.after / row.before - 1 : row.after - row.before);
  }
  return change < 0;  // not with a figure that does not exist
}

/// "; verification: settling 3 of 4 seeds (jump)"
std::string verification_words(const std::vector<Verification>& objectives) {
  if (objectives.empty()) return "; not verified with other seeds";
  std::string words;
  for (const Verification& row : objectives) {
    words += fmt::format("{}{} better with {} of {} seeds ({})", words.empty() ? "" : ", ",
                         row.figure, row.better, row.seeds, row.scenario);
  }
  return "; verification: " + words;
}

/// Explains the dashes of the tables; empty: there are none.
std::string dash_note(const TuneResult& result) {
  const auto is_open = [](double value) { return !std::isfinite(value); };
  const auto lacks = [&](const Candidate& each) {
    return std::ranges::any_of(each.objectives, is_open) ||
           std::ranges::any_of(each.guards, is_open);
  };
  const bool any = lacks(result.candidates[0]) || lacks(result.candidates[result.best]) ||
                   std::ranges::any_of(result.verification, [&](const Verification& row) {
                     return is_open(row.before) || is_open(row.after);
                   });
  if (!any) return "";
  return "A dash: with at least one seed the figure does not exist, as the settling time of a step "
         "that never settles within its time, or a flight that falls.";
}

bool falls_more(const TuneResult& result) { return result.fallen_after > result.fallen_before; }

std::string verdict_line(const TuneStudy& study, const TuneResult& result) {
  const Candidate& after = result.candidates[result.best];
  if (result.best == 0) {
    return fmt::format("none of {} candidates is better at these guards",
                       result.candidates.size() - 1);
  }
  std::string line = fmt::format("candidate {} of {}: weighted sum {} instead of {}", after.number,
                                 result.candidates.size() - 1, four_digits(after.sum),
                                 four_digits(result.candidates[0].sum));
  line += verification_words(verified_objectives(study, result));
  if (falls_more(result)) line += "; but more flights of the verification fell than before";
  return line;
}

std::string verification_line(const TuneResult& result) {
  return fmt::format(
      "seeds that the search never used; of {} flights with each, {} did not stay up before and {} "
      "after",
      result.verify_flights, result.fallen_before, result.fallen_after);
}

Plot front_plot(const TuneStudy& study, const TuneResult& result, std::size_t x, std::size_t y) {
  Plot plot{.title = "Candidates whose guards hold",
            .x_label = study.objectives[x].figure.name,
            .y_label = study.objectives[y].figure.name};
  Series front{.name = "front", .points = {}};
  for (const std::size_t i : result.front) {
    front.points.emplace_back(result.candidates[i].objectives[x],
                              result.candidates[i].objectives[y]);
  }
  std::ranges::sort(front.points);
  plot.series.push_back(std::move(front));
  for (const auto& [name, index] : {std::pair<const char*, std::size_t>{"before", 0},
                                    std::pair<const char*, std::size_t>{"after", result.best}}) {
    const std::vector<double>& at = result.candidates[index].objectives;
    plot.series.push_back({.name = name, .points = {{at[x], at[y]}}, .dots = true});
  }
  return plot;
}

}  // namespace

std::string candidates_csv(const TuneStudy& study, const TuneResult& result,
                           const std::vector<std::size_t>& rows) {
  std::string text = "candidate";
  for (const TuneParameter& each : study.vary) text += "," + csv_field(each.parameter.name);
  for (const Objective& each : study.objectives) text += "," + csv_field(each.figure.name);
  for (const Guard& each : study.guards) text += "," + csv_field("guard " + each.figure.name);
  text += ",fallen,penalty,weighted_sum\n";
  for (const std::size_t row : rows) {
    const Candidate& own = result.candidates[row];
    text += std::to_string(own.number);
    for (const std::string& value : own.values) text += "," + value;
    for (const double value : own.objectives) text += "," + field(value);
    for (const double value : own.guards) text += "," + field(value);
    text += fmt::format(",{},{},{}\n", own.fallen, own.penalty, own.sum);
  }
  return text;
}

std::string gains_yaml(const TuneStudy& study, const Candidate& candidate) {
  std::string params;
  std::string others;
  for (const auto& [key, value] : study.values_of(candidate.values)) {
    if (key.starts_with(kParams)) {
      params += fmt::format("  {}: {}\n", key.substr(kParams.size()), value);
    } else {
      others += fmt::format("  \"{}\": {}\n", key, value);
    }
  }
  std::string text =
      fmt::format("# hils tune, study {}, candidate {}\n", study.name, candidate.number);
  if (!params.empty()) text += "params:\n" + params;
  if (!others.empty()) text += "set:\n" + others;
  return text;
}

std::string gains_params(const TuneStudy& study, const Candidate& candidate) {
  std::string text;
  for (const auto& [key, value] : study.values_of(candidate.values)) {
    if (key.starts_with(kParams)) text += fmt::format("{} {}\n", key.substr(kParams.size()), value);
  }
  return text;
}

Document tune_report(const TuneStudy& study, const TuneResult& result,
                     const std::vector<Plot>& steps) {
  Document page{"Tuning " + study.name};
  const bool better = result.best != 0;
  const std::vector<Verification> objectives = verified_objectives(study, result);
  const bool confirmed = is_confirmed(study, objectives) && !falls_more(result);
  page.add(Document::Verdict{better && confirmed ? Mood::kGood : Mood::kNeutral,
                             !better     ? "NONE BETTER"
                             : confirmed ? "BETTER"
                                         : "BETTER IN THE SEARCH",
                             study.name + ": " + verdict_line(study, result),
                             result.warnings.sentences()});
  if (!study.description.empty()) page.paragraph(study.description);
  page.table("Values", value_rows(study, result));
  page.table("Over the search's scenarios and seeds: mean of the seeds, worst of the scenarios",
             objective_rows(study, result));
  if (!result.verification.empty()) {
    page.table("Verification: " + verification_line(result), verification_rows(result));
  }
  if (const std::string note = dash_note(result); !note.empty()) page.paragraph(note);
  if (!steps.empty()) page.heading("Step responses", Extent::kPage);
  for (const Plot& plot : steps) page.add(plot);
  if (!result.front.empty() && study.objectives.size() > 1) {
    page.heading("Front", Extent::kPage);
    page.paragraph(fmt::format(
        "{} of {} candidates hold all guards and are beaten by no other in all objectives: "
        "front.csv. candidates.csv has all of them.",
        result.front.size(), result.candidates.size()));
    for (std::size_t y = 1; y < study.objectives.size(); ++y) {
      page.add(front_plot(study, result, 0, y));
    }
  }
  page.heading("Flights", Extent::kPage);
  Document::Links flights;
  for (const TuneScenario& each : study.scenarios) {
    for (const char* when : {"before", "after"}) {
      flights.list.emplace_back(fmt::format("{}/{}/report.html", when, each.name),
                                fmt::format("{}, {}", each.name, when));
    }
  }
  page.add(std::move(flights));
  page.add(Document::Folded{"gains.yaml", gains_yaml(study, result.candidates[result.best])});
  return page;
}

}  // namespace cas::hils
