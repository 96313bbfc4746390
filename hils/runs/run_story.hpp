// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace cas::hils {

/// A line of a story: what it is about, and the rest.
struct StoryLine {
  std::string head;
  std::string text;

  bool operator==(const StoryLine&) const = default;
};

/// What a run was and how it went: the flight, its verdict, the first cause of a failure with its
/// consequences below it, faults with the vehicle's reactions, the limits with the least left, and
/// what was flown otherwise than the files say. The first thing to go wrong in simulated time is
/// taken for the cause; a limit that is missed without an incident and without a broken-off flight
/// has none but itself.
/// @param summary  summary.json
/// @param record   of the replay; null: the story lacks what only it has
/// @throws base::ConfigError for members that are not as hils writes them
std::vector<StoryLine> run_story(const nlohmann::json& summary, const nlohmann::json& record);

/// The lines with their heads in one column.
std::string story_text(const std::vector<StoryLine>& lines);

}  // namespace cas::hils
