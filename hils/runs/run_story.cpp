// SPDX-License-Identifier: BSD-3-Clause
#include "hils/runs/run_story.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "base/angles.hpp"
#include "base/error.hpp"
#include "base/printable.hpp"
#include "base/text.hpp"
#include "hils/report/number_text.hpp"

namespace cas::hils {

namespace {

using Json = nlohmann::json;
using Lines = std::vector<StoryLine>;

constexpr double kAfterFault_s = 5;      // in which the vehicle may still react to one
constexpr double kBeforeFailure_s = 10;  // in which it may have said why
constexpr double kTakesMode_s = 2;       // from a command to the HEARTBEAT with its mode
constexpr int kWarning = 4;              // MAV_SEVERITY_WARNING
constexpr std::size_t kMostTexts = 3;
constexpr std::size_t kMostLimits = 3;
constexpr int kMostDigits = 17;

std::string seconds(double t_s) { return fixed(t_s, 2) + " s"; }

std::vector<std::string> strings_of(const Json& list) {
  return list.is_array() ? list.get<std::vector<std::string>>() : std::vector<std::string>{};
}

/// The first few of `all`; the rest are counted.
std::string first_few(const std::vector<std::string>& all, std::string_view separator,
                      std::size_t most) {
  const std::vector<std::string> shown(
      all.begin(), all.begin() + static_cast<std::ptrdiff_t>(std::min(most, all.size())));
  const std::string text = base::joined(shown, separator);
  return all.size() <= most ? text : fmt::format("{}, and {} more", text, all.size() - most);
}

const Json& member(const Json& object, const char* key) {
  static const Json kNone;
  return object.is_object() && object.contains(key) ? object[key] : kNone;
}

/// Something that happened at a moment of simulated time.
struct Moment {
  double t_s = 0;
  std::string what;
  bool is_mode = false;  ///< a change of mode
};

/// A series of a record: multiples of a step, each as the difference from the one before.
class RecordedSeries {
 public:
  explicit RecordedSeries(const Json& column) {
    if (!column.is_object()) return;
    const double step = column.at("k");
    double sum = 0;
    for (const Json& difference : column.at("d")) {
      sum += difference.get<double>();
      values_.push_back(sum * step);
    }
  }
  std::size_t size() const { return values_.size(); }
  double operator[](std::size_t i) const { return values_[std::min(i, values_.size() - 1)]; }
  const std::vector<double>& values() const { return values_; }

 private:
  std::vector<double> values_;
};

/// The true motion, as a record has it.
class Motion {
 public:
  explicit Motion(const Json& vehicle)
      : truth_(member(vehicle, "truth")),
        t_(member(truth_, "t")),
        roll_(member(truth_, "roll")),
        pitch_(member(truth_, "pitch")) {
    const Json& rotors = member(member(vehicle, "scene"), "rotors");
    for (std::size_t i = 0; i < rotors.size(); ++i) {
      const double most = rotors[i].value("omega_max_rad_s", 0.0);
      const RecordedSeries speed(member(truth_, fmt::format("rotor{}", i + 1).c_str()));
      if (most > 0 && speed.size() > 0) rotors_.emplace_back(speed, most);
    }
  }

  bool is_there() const { return t_.size() > 0 && roll_.size() > 0 && pitch_.size() > 0; }

  /// Height above the first place, speed, tilt, and how hard the rotors worked.
  std::string at(double t_s) const {
    const std::size_t i = index(t_s);
    const auto of = [&](const char* key) { return RecordedSeries(member(truth_, key)); };
    const RecordedSeries z = of("z");
    if (z.size() == 0) return "";
    const double speed = std::hypot(of("vx")[i], of("vy")[i], of("vz")[i]);
    std::string text = fmt::format("{} m high, {} m/s, tilted by {} deg", fixed(z[i] - z[0], 1),
                                   fixed(speed, 1), fixed(tilt_deg(i), 0));
    if (rotors_.empty()) return text;
    return text + fmt::format(", rotors at {} % of their highest speed in the 2 s before",
                              fixed(load_pct(t_s - 2, t_s), 0));
  }

  double greatest_tilt_deg(double begin_s, double end_s) const {
    double greatest = 0;
    for (std::size_t i = index(begin_s); i < t_.size() && t_[i] <= end_s; ++i) {
      greatest = std::max(greatest, tilt_deg(i));
    }
    return greatest;
  }

 private:
  std::size_t index(double t_s) const {
    const auto& all = t_.values();
    const auto after = std::ranges::upper_bound(all, t_s);
    return after == all.begin() ? 0 : static_cast<std::size_t>(after - all.begin()) - 1;
  }
  double tilt_deg(std::size_t i) const {
    return base::degrees(std::acos(std::clamp(std::cos(roll_[i]) * std::cos(pitch_[i]), -1., 1.)));
  }
  double load_pct(double begin_s, double end_s) const {
    double sum = 0;
    double count = 0;
    for (std::size_t i = index(begin_s); i < t_.size() && t_[i] <= end_s; ++i) {
      for (const auto& [speed, most] : rotors_) sum += 100 * speed[i] / most;
      count += static_cast<double>(rotors_.size());
    }
    return count > 0 ? sum / count : 0;
  }

  const Json& truth_;
  RecordedSeries t_;
  RecordedSeries roll_;
  RecordedSeries pitch_;
  std::vector<std::pair<RecordedSeries, double>> rotors_;  ///< speed, highest speed
};

/// What the vehicle said from one moment to another: warnings and worse, and changes of mode.
std::vector<Moment> said(const Json& vehicle, double begin_s, double end_s) {
  const Json& log = member(vehicle, "log");
  std::vector<Moment> all;
  for (const Json& text : member(log, "texts")) {
    const double t_s = text.at(0);
    if (t_s < begin_s || t_s > end_s || text.at(1).get<int>() > kWarning) continue;
    all.push_back({t_s, "said '" + text.at(2).get<std::string>() + "'", false});
  }
  std::string before;
  for (const Json& state : member(log, "states")) {
    const double t_s = state.at(0);
    const std::string mode = state.at(2);
    if (!before.empty() && mode != before && t_s >= begin_s && t_s <= end_s) {
      all.push_back({t_s, "changed to " + mode, true});
    }
    before = mode;
  }
  std::ranges::stable_sort(all, {}, &Moment::t_s);
  return all;
}

/// The story of one vehicle.
class VehicleStory {
 public:
  /// @param record         of this vehicle, or null
  /// @param mean_wind_m_s  null: no wind, or not known
  VehicleStory(const Json& summary, const Json& record, const Json& mean_wind_m_s)
      : summary_(summary), record_(record), mean_wind_m_s_(mean_wind_m_s), motion_(record) {}

  Lines lines() {
    Lines lines;
    add_steps(lines);
    add_failure(lines);
    add_faults(lines);
    add_losses(lines);
    add_margins(lines);
    add_changes(lines);
    return lines;
  }

 private:
  void add_steps(Lines& lines) const {
    std::vector<std::string> steps;
    for (const Json& stage : member(summary_, "stages")) {
      const double took_s = stage.at("end_s").get<double>() - stage.at("begin_s").get<double>();
      steps.push_back(fmt::format("{} {} s{}", stage.at("name").get<std::string>(),
                                  fixed(took_s, 1),
                                  stage.value("finished", true) ? "" : ", not done"));
    }
    if (!steps.empty()) lines.push_back({"steps", base::joined(steps, ", ")});
  }

  /// Failures that have a time, in its order. @param rest  takes the others
  std::vector<Moment> failed_moments(std::vector<std::string>& rest) const {
    std::vector<Moment> moments;
    const std::vector<std::string> failures = strings_of(member(summary_, "failures"));
    const Json& times_s = member(summary_, "failure_times_s");
    for (std::size_t i = 0; i < failures.size(); ++i) {
      if (i < times_s.size() && times_s[i].is_number()) {
        moments.push_back({times_s[i], failures[i], false});
      } else {
        rest.push_back(failures[i]);
      }
    }
    std::ranges::stable_sort(moments, {}, &Moment::t_s);
    return moments;
  }

  void add_failure(Lines& lines) const {
    std::vector<std::string> rest;
    const std::vector<Moment> moments = failed_moments(rest);
    if (moments.empty()) {
      const char* const head = summary_.value("valid", true) ? "missed" : "why";
      for (const std::string& each : rest) lines.push_back({head, each});
      return;
    }
    const Moment& first = moments.front();
    lines.push_back({"first", first.what});
    add_circumstances(first.t_s, lines);
    for (std::size_t i = 1; i < moments.size(); ++i) {
      lines.push_back({"then", moments[i].what});
    }
    if (!rest.empty()) lines.push_back({"therefore", first_few(rest, "; ", kMostLimits)});
  }

  /// Adds the circumstances of the moment at which the first thing went wrong.
  void add_circumstances(double t_s, Lines& lines) const {
    if (motion_.is_there()) lines.push_back({"", "at that moment " + motion_.at(t_s)});
    if (mean_wind_m_s_.is_number() && mean_wind_m_s_.get<double>() > 0) {
      lines.push_back(
          {"", fmt::format("in a wind of {:g} m/s on average", mean_wind_m_s_.get<double>())});
    }
    std::optional<double> struck_s;  // by the first fault that still acted
    for (const Json& fault : member(summary_, "faults")) {
      if (!fault.at("begin_s").is_number() || fault["begin_s"].get<double>() > t_s) continue;
      const bool over =
          fault.at("end_s").is_number() && fault["end_s"].get<double>() + kAfterFault_s < t_s;
      if (over) continue;
      struck_s = std::min(struck_s.value_or(t_s), fault["begin_s"].get<double>());
      lines.push_back({"", fmt::format("{} after fault '{}' had begun",
                                       seconds(t_s - fault["begin_s"].get<double>()),
                                       fault.at("name").get<std::string>())});
    }
    std::vector<std::string> words;
    const double from_s = std::max(t_s - kBeforeFailure_s, struck_s.value_or(0));
    for (const Moment& each : said(record_, from_s, t_s + 1)) {
      if (!struck_s && each.is_mode && is_planned(each.t_s)) continue;
      words.push_back(fmt::format("{} at {}", each.what, seconds(each.t_s)));
    }
    if (!words.empty()) lines.push_back({"", "the vehicle " + first_few(words, ", ", kMostTexts)});
  }

  /// Whether a change of mode then is a step's: it follows the step's command, or ends a takeoff.
  bool is_planned(double t_s) const {
    return std::ranges::any_of(member(summary_, "stages"), [&](const Json& stage) {
      const double begin_s = stage.at("begin_s");
      const double end_s =
          stage.at("step") == "takeoff" ? stage.at("end_s").get<double>() : begin_s;
      return t_s >= begin_s && t_s <= std::max(end_s, begin_s + kTakesMode_s);
    });
  }

  void add_faults(Lines& lines) const {
    for (const Json& fault : member(summary_, "faults")) {
      const auto name = fault.at("name").get<std::string>();
      if (!fault.at("begin_s").is_number()) {
        lines.push_back({"fault", fmt::format("'{}' never began", name)});
        continue;
      }
      const double begin_s = fault["begin_s"];
      const bool ended = fault.at("end_s").is_number();
      const double end_s = ended ? fault["end_s"].get<double>() : begin_s;
      std::string text = fmt::format("'{}' from {} {}", name, seconds(begin_s),
                                     ended ? "to " + seconds(end_s) : "on");
      const double until_s = end_s + kAfterFault_s;
      if (motion_.is_there()) {
        text += fmt::format("; until {} s later tilted by at most {} deg", kAfterFault_s,
                            fixed(motion_.greatest_tilt_deg(begin_s, until_s), 0));
      }
      std::vector<std::string> words;
      for (const Moment& each : said(record_, begin_s, until_s)) {
        words.push_back(fmt::format("{} after {}", each.what, seconds(each.t_s - begin_s)));
      }
      if (!words.empty()) text += "; the vehicle " + first_few(words, ", ", kMostTexts);
      lines.push_back({"fault", text});
    }
  }

  void add_losses(Lines& lines) const {
    for (const Json& path : member(summary_, "paths")) {
      const auto sent = path.at("sent").get<std::uint64_t>();
      const auto received = path.at("received").get<std::uint64_t>();
      if (received >= sent) continue;
      std::vector<std::string> causes;
      for (const auto& [cause, count] : member(path, "losses").items()) {
        causes.push_back(fmt::format("{} {}", count.get<std::uint64_t>(), cause));
      }
      lines.push_back(
          {"lost", fmt::format("{} of {} {}: {}", sent - received, sent,
                               path.at("message").get<std::string>(), base::joined(causes, ", "))});
    }
  }

  /// The kept limits with the least left of their bounds.
  void add_margins(Lines& lines) const {
    std::vector<std::pair<double, std::string>> kept;
    for (const Json& check : member(record_, "checks")) {
      if (!check.at("judged").get<bool>() || !check.at("kept").get<bool>()) continue;
      if (!check.at("bound").is_number() || !member(check, "margin").is_number()) continue;
      const double bound = check["bound"];
      if (bound == 0) continue;
      const double left_pct = 100 * check["margin"].get<double>() / std::abs(bound);
      const auto unit = check.at("unit").get<std::string>();
      const int digits = std::clamp(check.at("digits").get<int>(), 0, kMostDigits);
      kept.emplace_back(left_pct, fmt::format("{} {} of {:g}{}{} ({} % left)",
                                              check.at("what").get<std::string>(),
                                              fixed(check.at("value").get<double>(), digits), bound,
                                              unit.empty() ? "" : " ", unit, fixed(left_pct, 0)));
    }
    std::ranges::stable_sort(kept, {}, &std::pair<double, std::string>::first);
    std::vector<std::string> closest;
    for (const auto& [left, text] : kept) closest.push_back(text);
    if (closest.size() > kMostLimits) closest.resize(kMostLimits);
    if (!closest.empty()) lines.push_back({"closest", base::joined(closest, "; ")});
  }

  void add_changes(Lines& lines) const {
    for (const char* const key : {"warnings", "remarks"}) {
      const std::vector<std::string> sentences = strings_of(member(summary_, key));
      if (!sentences.empty()) lines.push_back({"note", first_few(sentences, "; ", kMostTexts)});
    }
    std::vector<std::string> acts;
    for (const Json& change : member(summary_, "changes")) {
      if (!change.at("from_outside").get<bool>()) continue;
      const auto by = change.at("by").get<std::string>();
      acts.push_back(fmt::format("{} {} -> {} by {} at {}",
                                 change.at("parameter").get<std::string>(), change.at("old").dump(),
                                 change.at("new").dump(), by,
                                 seconds(change.at("time_s").get<double>())));
    }
    for (const Json& act : member(summary_, "acts")) {
      acts.push_back(fmt::format("{} by {} at {}", act.at("what").get<std::string>(),
                                 act.at("by").get<std::string>(),
                                 seconds(act.at("time_s").get<double>())));
    }
    if (!acts.empty()) lines.push_back({"changed", first_few(acts, ", ", kMostTexts)});
  }

  const Json& summary_;
  const Json& record_;
  const Json& mean_wind_m_s_;
  Motion motion_;
};

std::string_view verdict_word(const Json& summary) {
  if (!summary.value("valid", false)) return "INVALID";
  return summary.value("passed", false) ? "PASSED" : "FAILED";
}

/// Who flew what, how long, on which clock.
std::string flown_text(const Json& summary, const Json& record) {
  std::vector<std::string> vehicles;
  const Json& records = member(record, "vehicles");
  for (std::size_t i = 0; i < summary["vehicles"].size(); ++i) {
    const auto name = summary["vehicles"][i].at("name").get<std::string>();
    vehicles.push_back(name);
    if (i >= records.size() || !member(records[i], "scene").is_object()) continue;
    const Json& scene = records[i]["scene"];
    vehicles.back() += fmt::format(" ({}, {:g} kg)", scene.at("name").get<std::string>(),
                                   scene.at("mass_kg").get<double>());
  }
  const Json& first = summary["vehicles"].front();
  std::string controller = record.is_object() ? record.value("controller", "") : "";
  if (first.contains("autopilot")) {
    controller = "stock " + first["autopilot"].get<std::string>() + " " +
                 first.value("firmware", std::string());
  }
  const bool is_virtual = summary.value("virtual_clock", false);
  const bool lockstep = summary.value("lockstep", false);
  return fmt::format(
      "{}{}, {}, seed {}: {} s {}", base::joined(vehicles, ", "),
      controller.empty() ? "" : " by " + controller, summary.value("architecture", std::string()),
      summary.value("seed", std::uint64_t{0}), fixed(summary.value("simulated_s", 0.0), 1),
      is_virtual ? "on the virtual clock"
      : lockstep ? "in lockstep"
                 : "in " + fixed(summary.value("wall_s", 0.0), 1) + " s");
}

Lines story(const Json& summary, const Json& record) {
  Lines lines;
  const std::string description = record.is_object() ? record.value("description", "") : "";
  lines.push_back(
      {std::string(verdict_word(summary)), summary.at("scenario").get<std::string>() +
                                               (description.empty() ? "" : ": " + description)});
  const Json& vehicles = summary.at("vehicles");
  if (vehicles.empty()) return lines;
  lines.push_back({"flown", flown_text(summary, record)});
  const Json none;
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    const Json& records = member(record, "vehicles");
    const Json& own = i < records.size() ? records[i] : none;
    if (vehicles.size() > 1) {
      lines.push_back(
          {vehicles[i].at("name").get<std::string>(), std::string(verdict_word(vehicles[i]))});
    }
    VehicleStory vehicle(vehicles[i], own, member(record, "mean_wind_m_s"));
    for (StoryLine& line : vehicle.lines()) lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace

std::vector<StoryLine> run_story(const Json& summary, const Json& record) {
  try {
    return story(summary, record);
  } catch (const Json::exception&) {
    throw base::ConfigError("the run's summary or record is not as hils writes it");
  }
}

std::string story_text(const std::vector<StoryLine>& lines) {
  std::size_t width = 0;
  for (const StoryLine& line : lines) width = std::max(width, line.head.size());
  std::string text;
  for (const auto& [head, words] : lines) {
    text += fmt::format("{:<{}}  {}\n", head, width, words);
  }
  return base::printable_lines(text);
}

}  // namespace cas::hils
