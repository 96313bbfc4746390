// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/campaign_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/enum_words.hpp"
#include "base/text.hpp"
#include "hils/measure/check_json.hpp"
#include "hils/measure/strike_fields.hpp"
#include "hils/report/aligned_table.hpp"
#include "hils/report/html_page.hpp"
#include "hils/report/junit.hpp"
#include "hils/report/number_text.hpp"
#include "hils/sweep/run_table.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr base::EnumWords<CellState::kNoVerdict> kCellWords{"as expected", "missed", "no verdict"};

const std::string& phase_name(const CampaignMatrix& matrix, const CellResult& cell) {
  return matrix.campaign.phases[cell.cell.phase].name;
}

const CampaignFailure& failure_of(const CampaignMatrix& matrix, const CellResult& cell) {
  return matrix.campaign.failures[cell.cell.failure];
}

std::string expected_words(const CampaignMatrix& matrix, const CellResult& cell) {
  return base::joined(failure_of(matrix, cell).expected.at(phase_name(matrix, cell)), ", ",
                      [](const Expectation& each) { return to_string(each); });
}

std::string seconds(const std::optional<double>& time_s) {
  return time_s ? fixed(*time_s, 2) + " s" : std::string("-");
}

std::ptrdiff_t missed_flights(const CellResult& cell) {
  return std::ranges::count_if(cell.flights,
                               [](const CampaignFlight& flight) { return !flight.misses.empty(); });
}

/// Whether a flight of a cell has figures.
bool has_figures(const CellResult& cell) {
  return std::ranges::any_of(
      cell.flights, [](const CampaignFlight& flight) { return flight.response.has_value(); });
}

/// "ok  0.31 s", "MISSED 2/5  -": with the time to detect.
std::string cell_word(const CellResult& cell) {
  const std::size_t seeds = cell.flights.size();
  std::string word;
  switch (cell.state()) {
    case CellState::kAsExpected:
      word = "ok";
      break;
    case CellState::kMissed:
      word = "MISSED";
      if (seeds > 1) word += fmt::format(" {}/{}", missed_flights(cell), seeds);
      break;
    case CellState::kNoVerdict:
      return "no verdict";
  }
  return word + "  " + seconds(cell.detected_s());
}

/// Why a cell is not as expected: of the flight that is shown.
std::string cell_cause(const CellResult& cell) {
  const CampaignFlight& flight = cell.shown();
  if (!flight.response) return fmt::format("seed {}: {}", flight.seed, flight.no_verdict);
  return fmt::format("seed {}: {}", flight.seed, fmt::join(flight.misses, "; "));
}

std::optional<std::string_view> obstacle(const CampaignMatrix& matrix,
                                         const CampaignFailure& failure) {
  return hils::obstacle(*failure.failure, matrix.campaign.is_on_boards());
}

/// Failures that were not flown at all.
std::vector<const CampaignFailure*> not_flown(const CampaignMatrix& matrix) {
  std::vector<const CampaignFailure*> failures;
  for (const CampaignFailure& failure : matrix.campaign.failures) {
    if (obstacle(matrix, failure)) failures.push_back(&failure);
  }
  return failures;
}

/// Remarks on the campaign as a whole.
std::vector<std::string> remarks(const CampaignMatrix& matrix) {
  std::vector<std::string> sentences;
  if (!matrix.stopped.empty()) sentences.push_back("ended early: " + matrix.stopped);
  for (const CampaignFailure* failure : not_flown(matrix)) {
    sentences.push_back(
        fmt::format("{}: not flown; it {}", failure->name, *obstacle(matrix, *failure)));
  }
  if (const auto& names = matrix.campaign.left_out; !names.empty()) {
    sentences.push_back(fmt::format("left out by --only: {}", fmt::join(names, ", ")));
  }
  std::ranges::copy(matrix.without_failure, std::back_inserter(sentences));
  for (const std::size_t row : matrix.flown_otherwise) {
    sentences.push_back(fmt::format(
        "row {}: another flight when it was flown again; its replay does not show what was judged",
        row));
  }
  return sentences;
}

std::string headline(const CampaignMatrix& matrix) {
  std::size_t flights = 0;
  for (const CellResult& cell : matrix.cells) flights += cell.flights.size();
  std::string text =
      fmt::format("{} of {} cells as expected, {} missed, {} without a verdict; {} flights",
                  matrix.count(CellState::kAsExpected), matrix.cells.size(),
                  matrix.count(CellState::kMissed), matrix.count(CellState::kNoVerdict), flights);
  const std::size_t left_out = not_flown(matrix).size();
  if (left_out > 0) text += fmt::format("; not flown: {}", left_out);
  return text;
}

HtmlPage::Cell html_cell(const CellResult& cell, const fs::path& again) {
  const CampaignFlight& shown = cell.shown();
  HtmlPage::Cell html{.text = cell_word(cell)};
  html.mood = cell.state() == CellState::kAsExpected ? HtmlPage::Mood::kGood
              : cell.state() == CellState::kMissed   ? HtmlPage::Mood::kBad
                                                     : HtmlPage::Mood::kNeutral;
  html.detail = has_figures(cell)
                    ? fmt::format("react {}, {:.1f} m off, {:.0f} deg", seconds(cell.reacted_s()),
                                  cell.farthest_m(), cell.peak_tilt_deg())
                    : std::string("-");
  if (shown.response && !shown.response->detected_by.empty()) {
    html.detail += "; " + shown.response->detected_by;
  }
  const std::string folder = fmt::format("row_{}", shown.row);
  for (const char* file : {"replay.html", "report.html"}) {
    if (!fs::exists(again / folder / file)) continue;
    html.address = again.filename().string() + "/" + folder + "/" + file;
    break;
  }
  return html;
}

void add_matrix(const CampaignMatrix& matrix, const fs::path& again, HtmlPage& html) {
  std::vector<std::string> headings{"Failure"};
  for (const CampaignPhase& phase : matrix.campaign.phases) headings.push_back(phase.name);
  std::vector<std::vector<HtmlPage::Cell>> rows;
  for (std::size_t i = 0; i < matrix.campaign.failures.size(); ++i) {
    const CampaignFailure& failure = matrix.campaign.failures[i];
    std::vector<HtmlPage::Cell>& row = rows.emplace_back();
    row.push_back({.text = failure.name, .detail = std::string(failure.failure->meaning)});
    for (std::size_t j = 0; j < matrix.campaign.phases.size(); ++j) {
      if (const CellResult* cell = matrix.find(i, j)) {
        row.push_back(html_cell(*cell, again));
      } else {
        const std::optional<std::string_view> why = obstacle(matrix, failure);
        const bool strikes = failure.expected.contains(matrix.campaign.phases[j].name);
        row.push_back(strikes && why
                          ? HtmlPage::Cell{.text = "not flown", .detail = std::string(*why)}
                          : HtmlPage::Cell{.text = "-"});
      }
    }
  }
  html.matrix(
      "Time to detect; below it time to react, farthest off the planned path, peak tilt and "
      "the first sign. The worst of all seeds; a cell leads to the replay of one flight: the "
      "first that missed, else the first",
      headings, rows);
}

void add_missed(const CampaignMatrix& matrix, HtmlPage& html) {
  std::vector<std::vector<std::string>> rows{{"Failure", "Phase", "Expected", "What came of it"}};
  for (const CellResult& cell : matrix.cells) {
    if (cell.state() == CellState::kAsExpected) continue;
    rows.push_back({failure_of(matrix, cell).name, phase_name(matrix, cell),
                    expected_words(matrix, cell), cell_cause(cell)});
  }
  if (rows.size() == 1) return;
  html.heading("Not as expected");
  html.table("Of the flight that the cell leads to", rows);
}

void add_flights(const CampaignMatrix& matrix, HtmlPage& html) {
  std::vector<std::vector<std::string>> rows{{"Failure in phase", "Seed", "Verdict", "Struck, s",
                                              "Detect", "React", "Reaction", "Off, m", "Tilt, deg",
                                              "End"}};
  std::vector<HtmlPage::Row> looks;
  for (const CellResult& cell : matrix.cells) {
    for (const CampaignFlight& flight : cell.flights) {
      const bool good = flight.response && flight.misses.empty();
      looks.push_back(good ? HtmlPage::Row::kPlain : HtmlPage::Row::kMissed);
      std::vector<std::string>& row = rows.emplace_back();
      row = {failure_of(matrix, cell).name + ", " + phase_name(matrix, cell),
             std::to_string(flight.seed),
             good              ? "ok"
             : flight.response ? "missed"
                               : "no verdict"};
      if (!flight.response) {
        row.resize(rows.front().size(), "-");
        continue;
      }
      const StrikeResponse& got = *flight.response;
      const std::string end = got.crashed     ? "crashed"
                              : got.completed ? "as planned"
                              : got.at_rest   ? "down early"
                                              : "not completed";
      row.insert(row.end(), {fixed(got.strike_s, 2), seconds(got.detected_s),
                             seconds(got.reacted_s), got.reaction.empty() ? "-" : got.reaction,
                             fixed(got.farthest_m, 2), fixed(got.peak_tilt_deg, 0), end});
    }
  }
  html.heading("Flights");
  html.table("Times count from the moment at which the failure struck", rows, looks);
}

/// A figure of a cell; null where no flight has it.
Json cell_json(const CellResult& cell, double value) {
  return has_figures(cell) ? number_or_null(value) : Json(nullptr);
}

/// Null is an empty cell, a truth value 1 or 0.
std::string csv_cell(const Json& value) {
  if (value.is_null()) return "";
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  if (value.is_number()) return fmt::format("{:.6g}", value.get<double>());
  return csv_field(value.get<std::string>());
}

Json flight_json(const CampaignFlight& flight) {
  Json json{{"row", flight.row},
            {"seed", flight.seed},
            {"as_expected", flight.response && flight.misses.empty()},
            {"missed", flight.misses}};
  if (!flight.response) {
    json["no_verdict"] = flight.no_verdict;
    return json;
  }
  for_each_strike_field(StrikeOutput::kJson, [&](const auto& field) {
    json[field.key] = field_json<Json>(*flight.response, field);
  });
  return json;
}

}  // namespace

std::string campaign_text(const CampaignMatrix& matrix) {
  std::vector<std::vector<std::string>> rows{{"failure"}};
  for (const CampaignPhase& phase : matrix.campaign.phases) rows.front().push_back(phase.name);
  for (std::size_t i = 0; i < matrix.campaign.failures.size(); ++i) {
    std::vector<std::string>& row = rows.emplace_back();
    row.push_back(matrix.campaign.failures[i].name);
    for (std::size_t j = 0; j < matrix.campaign.phases.size(); ++j) {
      const CellResult* cell = matrix.find(i, j);
      const CampaignFailure& failure = matrix.campaign.failures[i];
      const bool strikes = failure.expected.contains(matrix.campaign.phases[j].name);
      row.push_back(cell != nullptr ? cell_word(*cell) : strikes ? "not flown" : "-");
    }
  }
  std::string text = fmt::format("{}: {}\n\n{}\n", matrix.campaign.name, headline(matrix),
                                 aligned_table(rows, Cells::kLeft));
  for (const CellResult& cell : matrix.cells) {
    if (cell.state() == CellState::kAsExpected) continue;
    text += fmt::format("{} in {}: {}; {}\n", failure_of(matrix, cell).name,
                        phase_name(matrix, cell), kCellWords[cell.state()], cell_cause(cell));
  }
  for (const std::string& sentence : remarks(matrix)) text += sentence + "\n";
  return text;
}

std::string campaign_html(const CampaignMatrix& matrix, const fs::path& again) {
  HtmlPage html("Campaign: " + matrix.campaign.name);
  const int code = matrix.exit_code();
  html.verdict(code == 0   ? HtmlPage::Mood::kGood
               : code == 1 ? HtmlPage::Mood::kBad
                           : HtmlPage::Mood::kNeutral,
               code == 0   ? "As expected"
               : code == 1 ? "Not as expected"
                           : "No verdict",
               headline(matrix), remarks(matrix));
  if (!matrix.campaign.description.empty()) html.paragraph(matrix.campaign.description);
  add_matrix(matrix, again, html);
  add_missed(matrix, html);
  add_flights(matrix, html);
  return html.finish();
}

std::string campaign_junit(const CampaignMatrix& matrix) {
  using Outcome = JunitSuite::Outcome;
  JunitSuite suite("hils.campaign." + matrix.campaign.name);
  for (const CellResult& cell : matrix.cells) {
    const CellState state = cell.state();
    const bool as_expected = state == CellState::kAsExpected;
    suite.add(phase_name(matrix, cell),
              as_expected                   ? Outcome::kPassed
              : state == CellState::kMissed ? Outcome::kFailed
                                            : Outcome::kError,
              as_expected ? "" : cell_cause(cell), {}, failure_of(matrix, cell).name);
  }
  const auto skip = [&suite](const std::string& name, const std::string& why) {
    suite.add("all phases", Outcome::kSkipped, why, {}, name);
  };
  for (const CampaignFailure* failure : not_flown(matrix)) {
    skip(failure->name, fmt::format("it {}", *obstacle(matrix, *failure)));
  }
  for (const std::string& name : matrix.campaign.left_out) skip(name, "left out by --only");
  if (!matrix.stopped.empty()) suite.add("board", Outcome::kError, matrix.stopped);
  return suite.report();
}

std::string campaign_json(const CampaignMatrix& matrix) {
  Json json{{"schema", 1},
            {"campaign", matrix.campaign.name},
            {"cells_as_expected", matrix.count(CellState::kAsExpected)},
            {"cells_missed", matrix.count(CellState::kMissed)},
            {"cells_without_verdict", matrix.count(CellState::kNoVerdict)},
            {"not_flown", Json::array()},
            {"left_out", matrix.campaign.left_out},
            {"controllers", matrix.campaign.controllers},
            {"stopped", matrix.stopped},
            {"without_failure", matrix.without_failure},
            {"flown_otherwise", matrix.flown_otherwise},
            {"cells", Json::array()}};
  for (const CampaignFailure* failure : not_flown(matrix)) {
    json["not_flown"].push_back(failure->name);
  }
  for (const CellResult& cell : matrix.cells) {
    Json own{{"failure", failure_of(matrix, cell).name},
             {"kind", failure_of(matrix, cell).failure->name},
             {"phase", phase_name(matrix, cell)},
             {"verdict", kCellWords[cell.state()]},
             {"expected", expected_words(matrix, cell)},
             {"detected_s", number_or_null(cell.detected_s())},
             {"reacted_s", number_or_null(cell.reacted_s())},
             {"farthest_m", cell_json(cell, cell.farthest_m())},
             {"peak_tilt_deg", cell_json(cell, cell.peak_tilt_deg())},
             {"shown", fmt::format("again/row_{}", cell.shown().row)},
             {"flights", Json::array()}};
    for (const CampaignFlight& flight : cell.flights) own["flights"].push_back(flight_json(flight));
    json["cells"].push_back(std::move(own));
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string campaign_csv(const CampaignMatrix& matrix) {
  std::string text = "row,failure,phase,seed,verdict";
  std::string no_figures;
  for_each_strike_field(StrikeOutput::kCsv, [&](const auto& field) {
    text += fmt::format(",{}", field.key);
    no_figures += ",";
  });
  text += ",missed\n";
  for (const CellResult& cell : matrix.cells) {
    for (const CampaignFlight& flight : cell.flights) {
      const bool good = flight.response && flight.misses.empty();
      text += fmt::format("{},{},{},{},{}", flight.row, csv_field(failure_of(matrix, cell).name),
                          csv_field(phase_name(matrix, cell)), flight.seed,
                          good              ? "as expected"
                          : flight.response ? "missed"
                                            : "no verdict");
      if (!flight.response) {
        text += no_figures + "," + csv_field(flight.no_verdict) + "\n";
        continue;
      }
      for_each_strike_field(StrikeOutput::kCsv, [&](const auto& field) {
        text += "," + csv_cell(field_json<Json>(*flight.response, field));
      });
      text += "," + csv_field(fmt::format("{}", fmt::join(flight.misses, "; "))) + "\n";
    }
  }
  return text;
}

}  // namespace cas::hils
