// SPDX-License-Identifier: BSD-3-Clause
#include "hils/compare/comparison_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/text.hpp"
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

OrderedJson number_json(const std::optional<double>& value) {
  return value ? OrderedJson(*value) : OrderedJson(nullptr);
}

/// By the keys of the figures. @param mean_of  takes a FigureColumn
template <class MeanOf>
OrderedJson figures_json(const MeanOf& mean_of) {
  OrderedJson figures = OrderedJson::object();
  for (const Figure<Measurement>& row : figure_table()) figures[row.key] = mean_json(mean_of(&row));
  return figures;
}

/// Responses to the steps of the reference, by the keys of response_table().
OrderedJson responses_json(const Measurement& run) {
  OrderedJson responses = OrderedJson::array();
  for (const StepResponse& response : run.responses) {
    OrderedJson json{{"step", response.name}};
    for (const Figure<StepResponse>& figure : response_table()) {
      json[figure.key] = number_json(figure.get(response));
    }
    responses.push_back(std::move(json));
  }
  return responses;
}

/// Response to the fault that struck; null if none did.
OrderedJson strike_json(const Measurement& run) {
  if (!run.strike) return nullptr;
  return {{"fault", run.strike->fault},
          {"detected_s", number_json(run.strike->detected_s)},
          {"reacted_s", number_json(run.strike->reacted_s)},
          {"hold_farthest_m", number_json(run.strike->hold_farthest_m)},
          {"hold_tilt_deg", number_json(run.strike->hold_tilt_deg)}};
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
                    {"failures", result.verdicts[i].failures},
                    {"responses", responses_json(result.runs[i])},
                    {"strike", strike_json(result.runs[i])}});
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
    const VariantResult& one = results[a];
    const VariantResult& other = results[b];
    OrderedJson pair{{"of", one.variant.name()}, {"less", other.variant.name()}};
    pair["figures"] =
        figures_json([&](FigureColumn column) { return difference_of(one, other, column); });
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

/// A row of the side-by-side table.
struct SideBySide {
  std::string title;
  int digits;
  std::function<std::optional<double>(const Measurement&)> get;
};

/// Figures of the stream and of the measured hold by which vehicles are compared.
std::vector<SideBySide> stream_and_hold() {
  struct Choice {
    const char* key;
    const char* title;
  };
  static constexpr std::array<Choice, 14> kChoices{
      {{"real_time_factor", "pace"},
       {"sensor_hz", "HIL_SENSOR, Hz"},
       {"gps_hz", "HIL_GPS, Hz"},
       {"controls_hz", "controls, Hz"},
       {"sensor_delivered_pct", "HIL_SENSOR delivered, %"},
       {"controls_delivered_pct", "controls delivered, %"},
       {"sensor_to_control_p50_us", "HIL_SENSOR to control, p50, us"},
       {"sensor_to_control_p99_us", "HIL_SENSOR to control, p99, us"},
       {"rms_x_m", "hold: RMS north, m"},
       {"rms_y_m", "hold: RMS east, m"},
       {"rms_z_m", "hold: RMS height, m"},
       {"rms_yaw_rad", "hold: RMS yaw, rad"},
       {"peak_error_m", "hold: farthest, m"},
       {"rotor_activity_rad_s2", "hold: rotor activity, rad/s2"}}};
  std::vector<SideBySide> rows;
  for (const auto& [key, title] : kChoices) {
    const Figure<Measurement>& figure = figure_row(key);
    rows.push_back({title, figure.digits, [&figure](const Measurement& run) {
                      const bool of_machine = figure.part == Figure<Measurement>::Part::kRun;
                      return of_machine && run.virtual_clock ? std::nullopt : figure.get(run);
                    }});
  }
  return rows;
}

/// Telemetry of stock firmware to its ground station. Firmware in software waits for each packet of
/// its HIL stream, so that stream has no account.
std::vector<SideBySide> telemetry() {
  const auto rate = [](std::string message) {
    return [message](const Measurement& run) -> std::optional<double> {
      if (!run.firmware || !run.firmware->rates_hz.contains(message)) return std::nullopt;
      return run.firmware->rates_hz.at(message);
    };
  };
  return {{"telemetry: ATTITUDE, Hz", 2, rate("ATTITUDE")},
          {"telemetry: packets missed by their numbers", 0,
           [](const Measurement& run) -> std::optional<double> {
             if (!run.firmware) return std::nullopt;
             return static_cast<double>(run.firmware->lost);
           }}};
}

/// Reaction of a vehicle to the first fault of its scenario.
std::vector<SideBySide> reaction(const std::string& fault) {
  struct Part {
    const char* title;
    std::optional<double> (*get)(const StrikeResponse&);
  };
  static constexpr std::array<Part, 4> kParts{
      {{"noticed after, s", [](const StrikeResponse& s) { return s.detected_s; }},
       {"reacted after, s", [](const StrikeResponse& s) { return s.reacted_s; }},
       {"in the hold: farthest from where it struck, m",
        [](const StrikeResponse& s) { return s.hold_farthest_m; }},
       {"in the hold: largest tilt, deg",
        [](const StrikeResponse& s) { return s.hold_tilt_deg; }}}};
  std::vector<SideBySide> rows;
  for (const Part& part : kParts) {
    rows.push_back({fault + ": " + part.title, 2, [fault, get = part.get](const Measurement& run) {
                      return run.strike && run.strike->fault == fault ? get(*run.strike)
                                                                      : std::nullopt;
                    }});
  }
  return rows;
}

/// Response of a vehicle to one step of its reference.
std::vector<SideBySide> response(const std::string& step) {
  std::vector<SideBySide> rows;
  for (const Figure<StepResponse>& figure : response_table()) {
    rows.push_back({fmt::format("{}: {}, {}", step, figure.title, figure.unit), figure.digits,
                    [step, &figure](const Measurement& run) -> std::optional<double> {
                      const auto found =
                          std::ranges::find(run.responses, step, &StepResponse::name);
                      return found == run.responses.end() ? std::nullopt : figure.get(*found);
                    }});
  }
  return rows;
}

/// Names of faults or steps, each once, in the order in which they come.
template <class NamesOf>
std::vector<std::string> names_in(const std::vector<VariantResult>& results,
                                  const NamesOf& names_of) {
  std::vector<std::string> names;
  for (const VariantResult& result : results) {
    for (const Measurement& run : result.runs) {
      for (const std::string& name : names_of(run)) {
        if (std::ranges::find(names, name) == names.end()) names.push_back(name);
      }
    }
  }
  return names;
}

std::vector<SideBySide> side_by_side(const std::vector<VariantResult>& results) {
  std::vector<SideBySide> rows = stream_and_hold();
  const auto append = [&rows](std::vector<SideBySide> more) {
    std::ranges::move(more, std::back_inserter(rows));
  };
  append(telemetry());
  const auto faults = names_in(results, [](const Measurement& run) {
    return run.strike ? std::vector{run.strike->fault} : std::vector<std::string>{};
  });
  for (const std::string& fault : faults) append(reaction(fault));
  const auto steps = names_in(results, [](const Measurement& run) {
    std::vector<std::string> names;
    for (const StepResponse& each : run.responses) names.push_back(each.name);
    return names;
  });
  for (const std::string& step : steps) append(response(step));
  return rows;
}

/// Several scenarios in one table: a column for each, a row for each figure that one of them has.
void add_side_by_side(const std::vector<VariantResult>& results, Document& page) {
  Rows rows{{""}, {"controller"}};
  for (const VariantResult& result : results) {
    rows[0].push_back(result.variant.name());
    rows[1].push_back(result.runs.empty() ? "-" : how_it_ran(result.runs.front()));
  }
  for (const SideBySide& figure : side_by_side(results)) {
    Row row{figure.title};
    bool is_known = false;
    for (const VariantResult& result : results) {
      const auto mean = mean_of_runs(result, figure.get);
      is_known |= mean.has_value();
      row.push_back(to_text(mean, figure.digits));
    }
    if (is_known) rows.push_back(std::move(row));
  }
  page.table("Side by side: mean and 95 % interval of the valid runs", std::move(rows));
}

}  // namespace

Document comparison_report(const ComparisonPlan& plan, const std::vector<VariantResult>& results) {
  Document page{"Comparison: " + base::joined(plan.scenarios, ", ", &Scenario::name)};
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
  if (plan.has_several()) add_side_by_side(results, page);
  for (const ColumnGroup& group : comparison_groups()) {
    if (!has_figures(group, results)) continue;
    Rows rows = group_rows(group, results);
    std::vector<Look> looks(results.size(), Look::kPlain);
    looks.resize(rows.size() - 1, Look::kQuiet);
    page.table(group.title, std::move(rows), std::move(looks));
  }
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
