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
#include "hils/report/junit.hpp"
#include "hils/report/number_text.hpp"
#include "hils/sweep/run_table.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

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

/// Failures that were not flown at all.
std::vector<const CampaignFailure*> not_flown(const CampaignMatrix& matrix) {
  std::vector<const CampaignFailure*> failures;
  for (const CampaignFailure& failure : matrix.campaign.failures) {
    if (failure.obstacle) failures.push_back(&failure);
  }
  return failures;
}

/// Remarks on the campaign as a whole.
std::vector<std::string> remarks(const CampaignMatrix& matrix) {
  std::vector<std::string> sentences;
  if (!matrix.stopped.empty()) sentences.push_back("ended early: " + matrix.stopped);
  for (const CampaignFailure* failure : not_flown(matrix)) {
    sentences.push_back(fmt::format("{}: not flown; it {}", failure->name, *failure->obstacle));
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
  std::ranges::copy(matrix.warnings.sentences(), std::back_inserter(sentences));
  return sentences;
}

std::string headline(const CampaignMatrix& matrix) {
  std::size_t flights = 0;
  for (const CellResult& cell : matrix.cells) flights += cell.flights.size();
  std::string text = fmt::format(
      "{} of {} cells as expected, {} missed, {} without a verdict; {} flights "
      "with a failure and {} without",
      matrix.count(CellState::kAsExpected), matrix.cells.size(), matrix.count(CellState::kMissed),
      matrix.count(CellState::kNoVerdict), flights, matrix.references);
  const std::size_t left_out = not_flown(matrix).size();
  if (left_out > 0) text += fmt::format("; not flown: {}", left_out);
  return text;
}

Cell matrix_cell(const CellResult& cell, const fs::path& again) {
  const CampaignFlight& shown = cell.shown();
  Cell own = cell_word(cell);
  own.mood = cell.state() == CellState::kAsExpected ? Mood::kGood
             : cell.state() == CellState::kMissed   ? Mood::kBad
                                                    : Mood::kNeutral;
  own.detail = has_figures(cell)
                   ? fmt::format("react {}, {:.1f} m off, {:.0f} deg", seconds(cell.reacted_s()),
                                 cell.farthest_m(), cell.peak_tilt_deg())
                   : std::string("-");
  if (shown.response && !shown.response->detected_by.empty()) {
    own.detail += "; " + shown.response->detected_by;
  }
  const std::string folder = fmt::format("row_{}", shown.row);
  for (const char* file : {"replay.html", "report.html"}) {
    if (!fs::exists(again / folder / file)) continue;
    own.address = again.filename().string() + "/" + folder + "/" + file;
    break;
  }
  return own;
}

void add_matrix(const CampaignMatrix& matrix, const fs::path& again, Document& report) {
  Rows rows{{"Failure"}};
  for (const CampaignPhase& phase : matrix.campaign.phases) rows.front().push_back(phase.name);
  for (std::size_t i = 0; i < matrix.campaign.failures.size(); ++i) {
    const CampaignFailure& failure = matrix.campaign.failures[i];
    Row& row = rows.emplace_back(Row{failure.name});
    row.front().detail = failure.failure.meaning;
    for (std::size_t j = 0; j < matrix.campaign.phases.size(); ++j) {
      if (const CellResult* cell = matrix.find(i, j)) {
        row.push_back(matrix_cell(*cell, again));
      } else {
        const std::optional<std::string>& why = failure.obstacle;
        const bool strikes = failure.expected.contains(matrix.campaign.phases[j].name);
        Cell& cell_of_none = row.emplace_back(strikes && why ? "not flown" : "-");
        if (strikes && why) cell_of_none.detail = *why;
      }
    }
  }
  report.table(
      "Time to detect, the worst of all seeds. On the page a cell also has time to react, farthest "
      "off the planned path, peak tilt and the first sign, and leads to the replay of one flight: "
      "the first that missed, else the first",
      rows, {}, Align::kLeft);
}

void add_missed(const CampaignMatrix& matrix, Document& report) {
  Rows rows{{"Failure", "phase", "verdict", "expected", "what came of it"}};
  for (const CellResult& cell : matrix.cells) {
    if (cell.state() == CellState::kAsExpected) continue;
    rows.push_back({failure_of(matrix, cell).name, phase_name(matrix, cell),
                    std::string(kCellWords[cell.state()]), expected_words(matrix, cell),
                    cell_cause(cell)});
  }
  if (rows.size() == 1) return;
  report.table("Not as expected, in the flight that the cell leads to", rows, {}, Align::kLeft);
}

/// Null is an empty cell, a truth value 1 or 0.
std::string cell_text(const OrderedJson& value) {
  if (value.is_null()) return "";
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  if (value.is_number()) return fmt::format("{:.6g}", value.get<double>());
  return value.get<std::string>();
}

/// Every flight with its figures; empty cells where it has no verdict.
Document::Table flight_table(const CampaignMatrix& matrix) {
  Document::Table table{"Times count from the moment at which the failure struck",
                        {{"row", "failure", "phase", "seed", "verdict"}}};
  Row& heads = table.rows.front();
  for_each_strike_field(StrikeOutput::kCsv,
                        [&heads](const auto& field) { heads.push_back(field.key); });
  heads.push_back("missed");
  const std::size_t columns = heads.size();
  for (const CellResult& cell : matrix.cells) {
    for (const CampaignFlight& flight : cell.flights) {
      const bool good = flight.response && flight.misses.empty();
      table.looks.push_back(good ? Look::kPlain : Look::kMissed);
      Row& row =
          table.rows.emplace_back(Row{std::to_string(flight.row), failure_of(matrix, cell).name,
                                      phase_name(matrix, cell), std::to_string(flight.seed),
                                      good              ? "as expected"
                                      : flight.response ? "missed"
                                                        : "no verdict"});
      if (flight.response) {
        for_each_strike_field(StrikeOutput::kCsv, [&](const auto& field) {
          row.push_back(cell_text(field_json<OrderedJson>(*flight.response, field)));
        });
      }
      row.resize(columns - 1);
      row.push_back(flight.response ? fmt::format("{}", fmt::join(flight.misses, "; "))
                                    : flight.no_verdict);
    }
  }
  return table;
}

/// A figure of a cell; null where no flight has it.
OrderedJson cell_json(const CellResult& cell, double value) {
  return has_figures(cell) ? number_or_null(value) : OrderedJson(nullptr);
}

OrderedJson flight_json(const CampaignFlight& flight) {
  OrderedJson json{{"row", flight.row},
                   {"seed", flight.seed},
                   {"as_expected", flight.response && flight.misses.empty()},
                   {"missed", flight.misses}};
  if (!flight.response) {
    json["no_verdict"] = flight.no_verdict;
    return json;
  }
  for_each_strike_field(StrikeOutput::kJson, [&](const auto& field) {
    json[field.key] = field_json<OrderedJson>(*flight.response, field);
  });
  return json;
}

}  // namespace

Document campaign_report(const CampaignMatrix& matrix, const fs::path& again) {
  Document report{"Campaign: " + matrix.campaign.name};
  const int code = matrix.exit_code();
  report.add(Document::Verdict{code == 0   ? Mood::kGood
                               : code == 1 ? Mood::kBad
                                           : Mood::kNeutral,
                               code == 0   ? "As expected"
                               : code == 1 ? "Not as expected"
                                           : "No verdict",
                               matrix.campaign.name + ": " + headline(matrix), remarks(matrix)});
  if (!matrix.campaign.description.empty()) report.paragraph(matrix.campaign.description);
  add_matrix(matrix, again, report);
  add_missed(matrix, report);
  report.heading("Flights", Extent::kPage);
  report.add(flight_table(matrix));
  return report;
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
    skip(failure->name, fmt::format("it {}", *failure->obstacle));
  }
  for (const std::string& name : matrix.campaign.left_out) skip(name, "left out by --only");
  if (!matrix.stopped.empty()) suite.add("board", Outcome::kError, matrix.stopped);
  for (const std::string& sentence : matrix.warnings.sentences()) suite.say(sentence);
  return suite.report();
}

std::string campaign_json(const CampaignMatrix& matrix) {
  OrderedJson json{{"schema", 1},
                   {"campaign", matrix.campaign.name},
                   {"cells_as_expected", matrix.count(CellState::kAsExpected)},
                   {"cells_missed", matrix.count(CellState::kMissed)},
                   {"cells_without_verdict", matrix.count(CellState::kNoVerdict)},
                   {"not_flown", OrderedJson::array()},
                   {"left_out", matrix.campaign.left_out},
                   {"controllers", matrix.campaign.controllers},
                   {"stopped", matrix.stopped},
                   {"without_failure", matrix.without_failure},
                   {"flown_otherwise", matrix.flown_otherwise},
                   {"warnings", warnings_json<OrderedJson>(matrix.warnings)},
                   {"cells", OrderedJson::array()}};
  for (const CampaignFailure* failure : not_flown(matrix)) {
    json["not_flown"].push_back(failure->name);
  }
  for (const CellResult& cell : matrix.cells) {
    OrderedJson own{{"failure", failure_of(matrix, cell).name},
                    {"kind", failure_of(matrix, cell).failure.name},
                    {"phase", phase_name(matrix, cell)},
                    {"verdict", kCellWords[cell.state()]},
                    {"expected", expected_words(matrix, cell)},
                    {"detected_s", number_or_null(cell.detected_s())},
                    {"reacted_s", number_or_null(cell.reacted_s())},
                    {"farthest_m", cell_json(cell, cell.farthest_m())},
                    {"peak_tilt_deg", cell_json(cell, cell.peak_tilt_deg())},
                    {"shown", fmt::format("again/row_{}", cell.shown().row)},
                    {"flights", OrderedJson::array()}};
    for (const CampaignFlight& flight : cell.flights) own["flights"].push_back(flight_json(flight));
    json["cells"].push_back(std::move(own));
  }
  return json.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

std::string campaign_csv(const CampaignMatrix& matrix) {
  std::string text;
  for (const Row& row : flight_table(matrix).rows) {
    text += base::joined(row, ",", [](const Cell& cell) { return csv_field(cell.text); }) + "\n";
  }
  return text;
}

}  // namespace cas::hils
