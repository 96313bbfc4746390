// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/sweep_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <span>

#include "base/error.hpp"
#include "base/text.hpp"
#include "hils/report/number_text.hpp"
#include "hils/sweep/sweep_statistics.hpp"

namespace cas::hils {

namespace {

constexpr std::size_t kMostMapped = 4;  ///< parameters with a map of each pair
constexpr double kSignificant = 0.05;
constexpr const char* kStaysUp = "up";  ///< column of the results

std::string percent(double share) { return fmt::format("{:.2f} %", share * 100); }

std::string share_text(const ShareCell& cell) {
  if (cell.trials == 0) return "-";
  const ShareInterval range = cell.interval();
  return fmt::format("{} of {}, {} ({:.2f} to {:.2f})", cell.successes, cell.trials,
                     percent(cell.share()), range.low * 100, range.high * 100);
}

std::string p_text(double p) { return p < 1e-4 ? "< 0.0001" : fixed(p, 4); }

/// Figures whose distribution and sensitivity a page shows: those of the run and of the first
/// vehicle.
std::vector<std::pair<std::string, std::string>> shown_figures(const SweepView& view) {
  std::string prefix;
  if (!view.sweep.figures.empty()) {
    const std::string& last = view.sweep.figures[kRunFigures];
    if (const std::size_t dot = last.find('.'); dot != std::string::npos) {
      prefix = last.substr(0, dot + 1);
    }
  }
  std::vector<std::pair<std::string, std::string>> figures{
      {kStaysUp, "stays up"},
      {"crash_s", "first incident, s"},
      {"least_margin_pct", "least margin to a limit, %"}};
  for (const char* name : {"rms_x_m", "rms_y_m", "rms_z_m", "rms_yaw_rad",
                           "sensor_to_control_p99_us", "sensor_lost", "controls_lost"}) {
    figures.emplace_back(prefix + name, prefix + name);
  }
  return figures;
}

struct Sensitivity {
  std::string figure;  ///< its column
  std::string title;
  std::vector<std::optional<RankCorrelation>> by_parameter;
};

std::vector<Sensitivity> sensitivities(const SweepView& view) {
  std::vector<std::vector<double>> parameters;
  for (std::size_t i = 0; i < view.sweep.table.names.size(); ++i) {
    parameters.push_back(view.numbers(i));
  }
  std::vector<Sensitivity> result;
  for (const auto& [name, title] : shown_figures(view)) {
    const auto index = view.figure_index(name);
    if (!index) continue;
    const std::vector<double> values = view.figure(*index);
    Sensitivity row{.figure = name, .title = title, .by_parameter = {}};
    for (const std::vector<double>& parameter : parameters) {
      row.by_parameter.push_back(spearman(parameter, values));
    }
    const bool any = std::ranges::any_of(row.by_parameter, [](const auto& rho) { return !!rho; });
    if (any) result.push_back(std::move(row));
  }
  return result;
}

/// The parameters, those that staying up depends on most first.
std::vector<std::size_t> by_importance(const SweepView& view,
                                       const std::vector<Sensitivity>& table) {
  std::vector<std::size_t> order(view.sweep.table.names.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto up = std::ranges::find(table, kStaysUp, &Sensitivity::figure);
  if (up == table.end()) return order;
  std::ranges::stable_sort(order, std::ranges::greater(), [&](std::size_t i) {
    const auto& rho = up->by_parameter[i];
    return rho ? std::abs(rho->rho) : 0.0;
  });
  return order;
}

std::size_t parameter_named(const SweepView& view, const std::string& name) {
  const std::vector<std::string>& names = view.sweep.table.names;
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) {
    throw base::ConfigError("--map: there is no parameter '" + name + "'; there are " +
                            base::joined(names, ", "));
  }
  return static_cast<std::size_t>(found - names.begin());
}

void add_limits(const std::vector<ShareCheck>& checks, Document& report) {
  if (checks.empty()) return;
  Rows rows{{"Limit", "runs", "share of them", "at least", "at confidence", "limit", "result"}};
  std::vector<Look> looks;
  looks.reserve(checks.size());
  for (const ShareCheck& check : checks) {
    const ShareCell cell{check.successes, check.trials};
    rows.push_back({std::string(to_string(check.limit.share)),
                    fmt::format("{} of {}", check.successes, check.trials), percent(cell.share()),
                    percent(check.low), fmt::format("{:g} %", check.limit.confidence * 100),
                    fmt::format("{:g} %", check.limit.at_least * 100),
                    check.kept ? "kept" : "MISSED"});
    looks.push_back(check.kept ? Look::kPlain : Look::kMissed);
  }
  report.table("Limits; at least: one-sided lower bound of Clopper and Pearson", rows, looks);
}

/// Why a run did not stay up or has no verdict, in the words of the table; empty: it stayed up.
std::string why_not_up(const RowResult& result) {
  if (!result.incident.empty()) return "incident: " + result.incident;
  if (!is_judged(result.outcome) || result.outcome == RowOutcome::kStopped) {
    return fmt::format("{}: {}", to_string(result.outcome), result.cause);
  }
  if (result.figures.empty() || result.figures[kUpFigure] != 0) return "";
  return "not completed" + (result.unfinished.empty() ? "" : ": " + result.unfinished);
}

void add_outcomes(const SweepView& view, const SweepCounts& counts, Document& report) {
  std::map<std::string, std::size_t> outcomes;
  std::map<std::string, std::size_t> causes;
  for (const RowResult& result : view.results) {
    if (result.row == 0) continue;
    ++outcomes[std::string(to_string(result.outcome))];
    if (const std::string why = why_not_up(result); !why.empty()) ++causes[why];
  }
  Rows rows{{"Outcome", "Runs", "Share with its 95 % interval"}};
  for (const auto& [word, number] : outcomes) {
    rows.push_back({word, std::to_string(number), share_text({number, counts.flown})});
  }
  rows.push_back({"stays up (of those with a verdict)", std::to_string(counts.up),
                  share_text({counts.up, counts.judged})});
  if (counts.flown < counts.rows) {
    rows.push_back({"not flown", std::to_string(counts.rows - counts.flown), "-"});
  }
  report.table("Runs by outcome (interval of Clopper and Pearson)", rows);
  if (causes.empty()) return;
  std::vector<std::pair<std::string, std::size_t>> sorted(causes.begin(), causes.end());
  std::ranges::stable_sort(sorted, std::ranges::greater(),
                           &std::pair<std::string, std::size_t>::second);
  constexpr std::size_t kMost = 10;
  Rows table{{"Cause", "Runs"}};
  std::size_t others = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const auto& [cause, number] = sorted[i];
    if (i < kMost) {
      table.push_back({cause, std::to_string(number)});
    } else {
      others += number;
    }
  }
  if (others > 0) table.push_back({"other causes", std::to_string(others)});
  report.table("Why runs did not stay up, or have no verdict", table);
}

void add_maps(const SweepView& view, const SweepPage& page, const std::vector<std::size_t>& order,
              Document& report) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const auto& [x, y] : page.maps) {
    pairs.emplace_back(parameter_named(view, x), parameter_named(view, y));
  }
  const std::size_t mapped = std::min(order.size(), kMostMapped);
  for (std::size_t i = 0; i < mapped; ++i) {
    for (std::size_t j = i + 1; j < mapped; ++j) pairs.emplace_back(order[i], order[j]);
  }
  if (pairs.empty()) return;
  report.heading("Success maps", Extent::kPage);
  report.paragraph(
      "Colour and number: the share of runs that stay up, in percent. A frame is around the cells "
      "in which more than one half stays up at 95 % confidence (Clopper and Pearson); a question "
      "mark: the interval has one half inside. --map A,B draws any two parameters.");
  const std::vector<std::optional<bool>> up = view.up();
  for (const auto& [x, y] : pairs) {
    const Bins x_bins = view.bins(x);
    const Bins y_bins = view.bins(y);
    report.add(success_map(x_bins, y_bins, count_by(x_bins, y_bins, up)));
  }
}

/// Share of runs that stay up along a parameter, with the ends of the interval.
void add_shares(const SweepView& view, const std::vector<std::size_t>& order, Document& report) {
  report.heading("Along each parameter", Extent::kPage);
  const std::vector<std::optional<bool>> up = view.up();
  for (const std::size_t parameter : order) {
    const Bins bins = view.bins(parameter);
    const std::vector<ShareCell> cells = count_by(bins, up);
    Rows rows{{bins.name, "Stay up", "Of", "Share", "95 % interval"}};
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const ShareInterval range = cells[i].interval();
      rows.push_back({bins.labels[i], std::to_string(cells[i].successes),
                      std::to_string(cells[i].trials),
                      cells[i].trials > 0 ? percent(cells[i].share()) : "-",
                      fmt::format("{:.2f} to {:.2f} %", range.low * 100, range.high * 100)});
      if (rows.size() > 50) break;
    }
    report.table("Stays up by " + bins.name, rows);
  }
}

std::optional<Plot> histogram(const std::string& title, std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return std::nullopt;
  const auto [low, high] = std::ranges::minmax(values);
  if (!(high > low)) return std::nullopt;
  constexpr std::size_t kBars = 30;
  std::array<double, kBars> bars{};
  for (const double value : values) {
    const double at = (value - low) / (high - low) * static_cast<double>(kBars);
    bars[std::min(static_cast<std::size_t>(at), kBars - 1)] += 1;
  }
  Plot plot{.title = title, .x_label = title, .y_label = "runs", .from_zero = true};
  Series series{.name = "runs", .steps = true};
  const double width = (high - low) / static_cast<double>(kBars);
  for (std::size_t i = 0; i < kBars; ++i) {
    series.points.emplace_back(low + width * static_cast<double>(i), bars[i]);
  }
  series.points.emplace_back(high, 0);
  plot.series.push_back(std::move(series));
  return plot;
}

void add_distributions(const SweepView& view, Document& report) {
  bool any = false;
  for (const auto& [name, title] : shown_figures(view)) {
    const auto index = view.figure_index(name);
    if (!index || *index == kUpFigure) continue;
    const auto plot = histogram(title, view.figure(*index));
    if (!plot) continue;
    if (!any) report.heading("Distributions", Extent::kPage);
    any = true;
    report.add(*plot);
  }
}

void add_sensitivity(const SweepView& view, const std::vector<Sensitivity>& table,
                     Document& report) {
  if (table.empty()) return;
  report.heading("Sensitivity", Extent::kPage);
  Rows rows{{"Spearman's rank correlation of"}};
  for (const std::string& name : view.sweep.table.names) rows.front().push_back(name);
  for (const Sensitivity& figure : table) {
    Row row{figure.title};
    for (const auto& rho : figure.by_parameter) {
      row.push_back(!rho ? "-" : fixed(rho->rho, 2) + (rho->is_significant() ? " *" : ""));
    }
    rows.push_back(std::move(row));
  }
  report.table(
      "From -1 (the more, the less) to 1; * differs from 0 at 95 %. It sees what rises or falls, "
      "not what has a best value in the middle",
      rows);
}

void add_worst(const SweepView& view, const SweepPage& page, Document& report) {
  if (page.worst.empty()) return;
  report.heading("Worst runs", Extent::kPage);
  Rows rows{{"Row", "Outcome", "First incident, s", "Least margin, %"}};
  for (const std::string& name : view.sweep.table.names) rows.front().push_back(name);
  rows.front().insert(rows.front().end(), {"Seed", "Cause"});
  std::vector<std::pair<std::string, std::string>> links;
  for (const std::size_t number : page.worst) {
    const RowResult& result = view.results[number - 1];
    const TableRow& row = view.sweep.row(number);
    const auto figure = [&result](std::size_t index) -> std::optional<double> {
      if (index >= result.figures.size() || !std::isfinite(result.figures[index])) return {};
      return result.figures[index];
    };
    Row cells{std::to_string(number), std::string(to_string(result.outcome)),
              fixed(figure(kCrashFigure), 2), fixed(figure(kMarginFigure), 1)};
    cells.insert(cells.end(), row.values.begin(), row.values.end());
    cells.insert(cells.end(), {std::to_string(row.seed), result.cause});
    rows.push_back(std::move(cells));
    if (std::ranges::find(page.flown_again, number) != page.flown_again.end()) {
      links.emplace_back(fmt::format("again/row_{}/report.html", number),
                         fmt::format("Row {}: the run again, with its report", number));
    }
  }
  report.table("First those that did not stay up, by the time of the first incident", rows);
  if (!links.empty()) report.add(Document::Links{links});
  report.paragraph(fmt::format("hils sweep show {} ROW prints the command that flies a row again.",
                               view.sweep.path.string()));
}

void add_comparison(const SweepView& view, const SweepView& before, Document& report) {
  report.heading("Against " + before.sweep.path.string());
  Rows rows{{"Share", "before", "now", "change", "p", "result"}};
  std::vector<Look> looks;
  for (const ShareChange& change : compare_sweeps(before, view)) {
    if (change.before.trials == 0 && change.after.trials == 0) continue;
    rows.push_back({change.what, share_text(change.before), share_text(change.after),
                    fmt::format("{:+.2f} %", change.change() * 100), p_text(change.p),
                    change.p >= kSignificant ? "same"
                    : change.change() < 0    ? "WORSE"
                                             : "better"});
    const bool worse = change.p < kSignificant && change.change() < 0;
    looks.push_back(worse ? Look::kMissed : Look::kPlain);
    if (rows.size() > 40) break;
  }
  report.table(
      "p: Fisher's exact test, how likely chance alone makes such a change; of the bins "
      "corrected by Holm's method. In red: worse, and p below 0.05",
      rows, looks);
  const ChangedRows changed = changed_rows(before, view);
  if (!changed.same_table) {
    report.paragraph("The tables are not the same: single rows are not compared.");
    return;
  }
  const auto list = [](const std::vector<std::size_t>& numbers) {
    const std::span first(numbers.data(), std::min<std::size_t>(numbers.size(), 20));
    return fmt::format("{}{}{}", first.empty() ? "" : ": ", fmt::join(first, ", "),
                       numbers.size() > 20 ? ", ..." : "");
  };
  report.paragraph(fmt::format(
      "Same table: {} rows stayed up before and do not now{}; {} rows do "
      "now and did not before{}.",
      changed.worse.size(), list(changed.worse), changed.better.size(), list(changed.better)));
}

Document::Verdict verdict_of(const SweepView& view, const SweepCounts& counts,
                             const std::vector<ShareCheck>& checks) {
  if (counts.flown == 0) {
    return {Mood::kNeutral, "Nothing was flown",
            fmt::format("{}, {} runs; 'hils sweep run {}' flies them", view.sweep.study.name,
                        counts.rows, view.sweep.path.string())};
  }
  const bool kept = std::ranges::all_of(checks, &ShareCheck::kept);
  const bool missing = counts.flown < counts.rows;
  std::vector<std::string> sentences;
  for (const ShareCheck& check : checks) {
    if (!check.kept) sentences.push_back(check.sentence());
  }
  if (missing) {
    sentences.push_back(fmt::format("{} runs have not been flown", counts.rows - counts.flown));
  }
  if (counts.judged < counts.flown) {
    sentences.push_back(fmt::format("{} runs have no verdict", counts.flown - counts.judged));
  }
  std::ranges::copy(warnings_of(view.results).sentences(), std::back_inserter(sentences));
  return {!kept                       ? Mood::kBad
          : missing || checks.empty() ? Mood::kNeutral
                                      : Mood::kGood,
          !kept            ? "Limits missed"
          : checks.empty() ? "Flown"
                           : "Limits kept",
          fmt::format("{}: {} of {} runs flown, {} with a verdict; stays up: {}; passed: {}",
                      view.sweep.study.name, counts.flown, counts.rows, counts.judged,
                      share_text({counts.up, counts.judged}),
                      share_text({counts.passed, counts.judged})),
          std::move(sentences)};
}

}  // namespace

Document sweep_report(const SweepView& view, const std::vector<ShareCheck>& checks,
                      const SweepPage& page) {
  const SweepCounts counts = view.counts();
  const Study& study = view.sweep.study;
  Document report{"Sweep: " + study.name};
  report.add(verdict_of(view, counts, checks));
  if (!study.description.empty()) report.paragraph(study.description);
  const std::vector<Sensitivity> table = sensitivities(view);
  const std::vector<std::size_t> order = by_importance(view, table);
  if (counts.flown > 0) add_limits(checks, report);
  add_outcomes(view, counts, report);
  if (page.before != nullptr) add_comparison(view, *page.before, report);
  add_maps(view, page, order, report);
  add_sensitivity(view, table, report);
  add_worst(view, page, report);
  add_shares(view, order, report);
  add_distributions(view, report);
  report.heading("Configuration", Extent::kPage);
  report.add(Document::Folded{"study.yaml", text_of_file(view.sweep.path / "study.yaml")});
  report.add(Document::Folded{"scenario.yaml", text_of_file(view.sweep.scenario())});
  return report;
}

}  // namespace cas::hils
