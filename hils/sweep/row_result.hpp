// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/enum_words.hpp"
#include "hils/measure/run_result.hpp"
#include "hils/measure/strike_response.hpp"
#include "hils/report/flight_warnings.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// How a run of a sweep ended.
enum class RowOutcome {
  kPassed,   ///< as `hils run`: valid, flown to the end, every limit kept
  kFailed,   ///< valid, and a limit was missed or the flight not completed
  kInvalid,  ///< the figures mean nothing
  kStopped,  ///< the flight could not go on: the vehicle fell out of the world
  kRefused,  ///< a file of the run is wrong
  kDied,     ///< the process of the run was ended by a signal or ended without a result
  kHung,     ///< the process of the run had no result at its deadline
};
/// The words in tables and journals.
inline constexpr base::EnumWords<RowOutcome::kHung> kRowOutcomes{
    "passed", "failed", "invalid", "stopped", "refused", "died", "hung"};
constexpr std::string_view to_string(RowOutcome outcome) { return kRowOutcomes[outcome]; }
/// Whether the vehicle was judged: the run itself did not break.
bool is_judged(RowOutcome outcome);
/// Whether the process of the run broke: such a row gives way to any other result of it.
inline bool is_broken(RowOutcome outcome) {
  return outcome == RowOutcome::kDied || outcome == RowOutcome::kHung;
}

/// Cost and host of a run; no comparison looks at them.
struct MachineFigures {
  double wall_s = 0;
  double cpu_s = 0;
  double max_rss_mib = 0;
  std::string host{};
};

/// One run of a sweep: a row of its results. Figures that are not there are NaN.
struct RowResult {
  std::size_t row = 0;
  RowOutcome outcome = RowOutcome::kInvalid;
  std::string cause{};            ///< sentences: missed limits, or why there is no verdict
  std::string incident{};         ///< the first of the flight: ground, crash, ...
  std::string unfinished{};       ///< name of the step that was not done; empty: flown to the end
  std::string version{};          ///< of CAS
  std::string truth_sha256{};     ///< of truth.csv; of several vehicles, one file after the other
  std::string run_sha256{};       ///< see run_sha256(); where the study varies `faults`
  std::vector<double> figures{};  ///< in the order of figure_names()
  MachineFigures machine{};
  std::string key{};                       ///< identifies the flight where no table of runs does
  std::optional<StrikeResponse> strike{};  ///< of the first vehicle, where a fault struck
  std::vector<std::string> warnings{};     ///< as Verdict::warnings, of all vehicles
};

/// Names of the figures, the same for every run of a study: first those of the run, then those of
/// each vehicle, with its name where there are several.
std::vector<std::string> figure_names(const Scenario& scenario);

/// Places of the run's own figures.
enum RunFigure : std::size_t {
  kUpFigure,         ///< 1: flown to the end without an incident that is not allowed
  kCrashFigure,      ///< simulated time of the first such incident
  kMarginFigure,     ///< least margin to a limit, % of the limit
  kSimulatedFigure,  ///< simulated time of the run
  kRunFigures,       ///< how many: those of the vehicles begin here
};

/// Outcome, cause, incident, warnings and figures of a flight; the rest of the row is not set. The
/// warnings do not name the scenario's folder, which differs from row to row.
RowResult row_of(const Scenario& scenario, const RunResult& run);

/// Warnings of the flown rows, those with a number.
FlightWarnings warnings_of(const std::vector<RowResult>& results);

/// A row of a run that gave no figures.
RowResult row_without_figures(RowOutcome outcome, std::string cause);

/// One line of a journal, JSON with a line break at its end.
std::string journal_line(const RowResult& result);
/// Reads one; nullopt where the line is torn or not one of ours.
std::optional<RowResult> parse_journal_line(std::string_view line);

/// Headings of a row's results behind the table's columns, and its fields: "outcome,up,..." with
/// a comma before each.
std::string result_headings(const std::vector<std::string>& figures);
std::string result_fields(const RowResult& result, std::size_t figures);

/// "row,wall_s,..." and a line of it.
std::string machine_headings();
std::string machine_line(const RowResult& result);

}  // namespace cas::hils
