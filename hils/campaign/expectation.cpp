// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/expectation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "base/suggestion.hpp"
#include "base/text.hpp"
#include "mavlink_gen/services/vehicle_modes.hpp"

namespace cas::hils {

namespace {

using Kind = Expectation::Kind;

/// Words that stand alone.
constexpr std::array<std::pair<std::string_view, Kind>, 7> kWords{
    {{"stays_up", Kind::kStaysUp},
     {"no_crash", Kind::kNoCrash},
     {"crashes", Kind::kCrashes},
     {"no_arming", Kind::kNoArming},
     {"terminates", Kind::kTerminates},
     {"detected", Kind::kDetected},
     {"lands", Kind::kLands}}};
/// Keys with a number.
constexpr std::array<std::pair<std::string_view, Kind>, 4> kKeys{
    {{"detected_within_s", Kind::kDetected},
     {"lands_within_m", Kind::kLands},
     {"no_farther_than_m", Kind::kFarthest},
     {"tilts_less_than_deg", Kind::kTilt}}};
constexpr std::string_view kFailsafe = "failsafe";
constexpr double kMost = 1e6;

[[noreturn]] void refuse(const base::ConfigNode& node, const std::string& word) {
  std::vector<std::string_view> known{kFailsafe};
  for (const auto& [each, kind] : kWords) known.push_back(each);
  for (const auto& [each, kind] : kKeys) known.push_back(each);
  node.fail("there is no expectation '" + word + "'; there are " + base::joined(known, ", ") +
            base::did_you_mean(word, known));
}

std::vector<std::string> parse_modes(const std::string& text) {
  std::vector<std::string> modes;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find('/', begin), text.size());
    modes.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return modes;
}

/// casd's words for the modes of PX4 and ArduPilot, and for those that cannot be commanded.
std::vector<std::string> failsafe_modes() {
  using mav::services::ModeSet;
  std::vector<std::string> modes{"TERMINATION"};
  for (const ModeSet set : {ModeSet::kPx4, ModeSet::kCopter, ModeSet::kPlane}) {
    for (const std::string_view word : mav::services::mode_words(set)) {
      if (std::ranges::find(modes, word) == modes.end()) modes.emplace_back(word);
    }
  }
  return modes;
}

/// A mode that no vehicle has would never be reached, nor its expectation met.
void check_mode(const base::ConfigNode& node, const std::string& mode) {
  if (mode.empty()) node.fail("is a mode such as LAND, or several: LAND/RTL");
  const std::vector<std::string> known = failsafe_modes();
  if (std::ranges::find(known, mode) != known.end()) return;
  node.fail(fmt::format("there is no mode '{}'; there are {}{}", mode, fmt::join(known, ", "),
                        base::did_you_mean(mode, known)));
}

Expectation parse_failsafe(const base::ConfigNode& node) {
  Expectation failsafe{.kind = Kind::kFailsafe};
  failsafe.modes = parse_modes(node.require<std::string>(kFailsafe));
  for (const std::string& mode : failsafe.modes) check_mode(node.at(kFailsafe), mode);
  if (node.has("within_s")) failsafe.most = node.require_in("within_s", 0, kMost);
  return failsafe;
}

Expectation parse_expectation(const base::ConfigNode& node) {
  if (node.is_scalar()) {
    const auto word = node.as<std::string>();
    for (const auto& [name, kind] : kWords) {
      if (name == word) return {.kind = kind};
    }
    refuse(node, word);
  }
  if (!node.is_map()) node.fail("an expectation is a word or a map, such as {lands_within_m: 10}");
  if (node.has(kFailsafe)) return parse_failsafe(node);
  const auto entries = node.entries();
  if (entries.size() != 1) node.fail("an expectation has one key");
  for (const auto& [name, kind] : kKeys) {
    if (name == entries.front().first) {
      return {.kind = kind, .most = node.require_in(name, 0, kMost)};
    }
  }
  refuse(node, entries.front().first);
}

std::string time_words(const std::optional<double>& time_s) {
  return time_s ? fmt::format("after {:.2f} s", *time_s) : std::string("never");
}

std::string how_it_ended(const StrikeResponse& response) {
  if (response.incident) {
    const bool more = response.crashed && *response.incident == IncidentKind::kGround;
    return fmt::format("incident: {}{}", to_string(*response.incident),
                       more ? ", and a crash" : "");
  }
  if (response.crashed) return "it was falling at the end";
  if (!response.completed) {
    return response.at_rest ? "it came down before the end of the plan"
                            : "the plan was not flown to its end";
  }
  return "it flew on";
}

/// Whether something came in time; `most` nothing: at any time.
bool in_time(const std::optional<double>& time_s, const std::optional<double>& most) {
  return time_s && (!most || *time_s <= *most);
}

bool holds(const Expectation& wanted, const StrikeResponse& got) {
  if (got.left_world) return false;
  switch (wanted.kind) {
    case Kind::kStaysUp:
      return got.completed && !got.incident && !got.crashed;
    case Kind::kNoCrash:
      return !got.crashed;
    case Kind::kCrashes:
      return got.crashed;
    case Kind::kNoArming:
      return got.tried_to_arm && !got.armed_after;
    case Kind::kTerminates:
      return got.terminated;
    case Kind::kDetected:
      return in_time(got.detected_s, wanted.most);
    case Kind::kFailsafe:
      return in_time(got.reacted_s, wanted.most) &&
             std::ranges::find(wanted.modes, got.reaction) != wanted.modes.end();
    case Kind::kLands:
      return !got.crashed && got.in_air && got.at_rest &&
             (!wanted.most || got.rest_m <= *wanted.most);
    case Kind::kFarthest:
      return got.farthest_m <= wanted.most.value_or(kMost);
    case Kind::kTilt:
      return got.peak_tilt_deg <= wanted.most.value_or(kMost);
  }
  return false;
}

std::string found_words(const Expectation& wanted, const StrikeResponse& got) {
  if (got.left_world) return "its true motion became no number";
  switch (wanted.kind) {
    case Kind::kStaysUp:
    case Kind::kNoCrash:
    case Kind::kCrashes:
      return how_it_ended(got);
    case Kind::kNoArming:
      return got.armed_after ? "it armed" : "the plan did not arm it after the strike";
    case Kind::kTerminates:
      return "it did not";
    case Kind::kDetected:
      return "detected " + time_words(got.detected_s);
    case Kind::kFailsafe:
      return got.reacted_s ? fmt::format("{} {}", got.reaction, time_words(got.reacted_s))
                           : std::string("no failsafe");
    case Kind::kLands:
      if (got.crashed) return how_it_ended(got);
      if (!got.in_air) return "it was not in the air";
      return got.at_rest ? fmt::format("it came to rest {:.1f} m away", got.rest_m)
                         : std::string("it was not at rest at the end");
    case Kind::kFarthest:
      return fmt::format("{:.2f} m", got.farthest_m);
    case Kind::kTilt:
      return fmt::format("{:.0f} deg", got.peak_tilt_deg);
  }
  return {};
}

}  // namespace

std::vector<Expectation> parse_expectations(const base::ConfigNode& list) {
  if (!list.is_list()) list.fail("is a list, such as [no_crash, {detected_within_s: 2}]");
  std::vector<Expectation> expectations;
  for (const base::ConfigNode& node : list.items()) {
    expectations.push_back(parse_expectation(node));
  }
  if (expectations.empty()) list.fail("is an empty list");
  return expectations;
}

std::string to_string(const Expectation& wanted) {
  const auto within = [&wanted](const char* unit) {
    return wanted.most ? fmt::format(" within {:g} {}", *wanted.most, unit) : std::string();
  };
  switch (wanted.kind) {
    case Kind::kStaysUp:
      return "stays up";
    case Kind::kNoCrash:
      return "no crash";
    case Kind::kCrashes:
      return "crashes";
    case Kind::kNoArming:
      return "no arming";
    case Kind::kTerminates:
      return "terminates";
    case Kind::kDetected:
      return "detected" + within("s");
    case Kind::kFailsafe:
      return "failsafe " + base::joined(wanted.modes, " or ") + within("s");
    case Kind::kLands:
      return "lands" + within("m");
    case Kind::kFarthest:
      return fmt::format("no farther than {:g} m", wanted.most.value_or(0));
    case Kind::kTilt:
      return fmt::format("tilts less than {:g} deg", wanted.most.value_or(0));
  }
  return "?";
}

std::optional<std::string> miss_of(const Expectation& expectation, const StrikeResponse& response) {
  if (holds(expectation, response)) return std::nullopt;
  return to_string(expectation) + ": " + found_words(expectation, response);
}

}  // namespace cas::hils
